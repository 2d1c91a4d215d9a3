// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/watch/watch.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "models/physics/measurement.h"

namespace octant {
namespace {

constexpr double kMonth_s = 30.0 * 24.0 * 3600.0;
constexpr double kHour_s = 3600.0;
/// What a thermometer that nobody checked may be off by, times 0.6 m/s a degree.
constexpr double kUncheckedAir_mps = 0.6;
/// What is let pass of a place that is not known better: this many sigmas.
constexpr double kCalibrationSigmas = 2.0;
/// Keeps the normal matrix regular; fixes are known better than to a metre or a radian.
constexpr double kWeakPrior = 1.0;

double cofactor_share(double controlled) { return std::max(controlled, 1e-3); }

}  // namespace

Watch::Watch(const Deployment& d, const WatchOptions& options)
    : motion_(d.motion),
      medium_(d.medium),
      timing_(d.timing),
      noise_(d.noise),
      correlated_(d.correlated_noise),
      state_(shared_state(d)),
      options_(options) {
  matter_m_ = options.matter_m.value_or(d.tolerance.beacon_m.value_or(0.03));
  const double c = d.speed_mps(medium_.temperature_degC);
  const auto beta = [&](double place_variance_m2, double delay_sigma_s) {
    const double late_m = c * std::hypot(delay_sigma_s, correlated_.pair_sigma_s);
    return std::max(0.5 * matter_m_, kCalibrationSigmas * std::sqrt(place_variance_m2 + late_m * late_m));
  };
  for (const DeploymentBeacon& b : d.beacons) {
    Member member;
    member.usable = b.status != BeaconStatus::kUndetermined;
    member.beta_m = beta(b.covariance_m2.trace() / 3.0, b.delay_sigma_s);
    beacons_.push_back(member);
  }
  for (const DeploymentReceiver& r : d.receivers) {
    Member member;
    member.beta_m = beta(r.sigma_m.squaredNorm() / 3.0, r.delay_sigma_s);
    receivers_.push_back(member);
  }
  pose_unknowns_ = unknowns_ = pose_dof(motion_);
  if (timing_.clock == Clock::kCycleOffset) offset_column_ = unknowns_++;
  const double unchecked_mps = medium_.model == MediumModel::kConstant ? 0.0 : kUncheckedAir_mps;
  first_speed_variance_ = speed_variance_ =
      d.speed_sigma_mps * d.speed_sigma_mps + unchecked_mps * unchecked_mps;
  if (first_speed_variance_ > 0.0) speed_column_ = unknowns_++;
  add_charts(beacons_, WatchKind::kBeaconLate, WatchKind::kBeaconMoved);
  add_charts(receivers_, WatchKind::kReceiverLate, WatchKind::kReceiverMoved);
  const double steps = options.fixes_per_s * kMonth_s;
  threshold_ =
      std::log(std::max(2.0, static_cast<double>(charts_.size()) * steps / options.false_alarms_a_month));
  rows_.resize(std::max<std::size_t>(64, 2 * beacons_.size() * receivers_.size()));
}

void Watch::add_charts(std::vector<Member>& members, WatchKind late, WatchKind moved) {
  for (std::size_t m = 0; m < members.size(); ++m) {
    members[m].first_chart = charts_.size();
    for (int k = 0; k < kSignatures; ++k)
      for (const double sign : {1.0, -1.0})
        charts_.push_back({.kind = k == 0 ? late : moved, .member = m, .signature = k, .sign = sign});
  }
}

void Watch::forget(Chart& chart) noexcept {
  chart.sum = CumulativeSum{};
  chart.score = chart.information = 0.0;
}

void Watch::restart() noexcept {
  for (Chart& chart : charts_) forget(chart);
  for (auto* members : {&beacons_, &receivers_})
    for (Member& member : *members) member.out = false;
  speed_offset_mps_ = 0.0;
  speed_variance_ = first_speed_variance_;
}

void Watch::let_speed_drift(double time_s) noexcept {
  const double hours = std::clamp((time_s - last_speed_s_) / kHour_s, 0.0, 24.0);
  last_speed_s_ = time_s;
  if (speed_column_ < 0) return;
  const double drift = options_.speed_drift_mps_per_hour;
  speed_variance_ = std::min(first_speed_variance_, speed_variance_ + drift * drift * hours);
}

bool Watch::predict(const Arrival& a, const Pose& T_map_vehicle, bool used, Row& row) noexcept {
  if (!a.beacon.valid() || a.beacon.index() >= beacons_.size() || !a.receiver.valid() ||
      a.receiver.index() >= receivers_.size())
    return false;
  Member& beacon = beacons_[a.beacon.index()];
  if (!beacon.usable || beacon.out || receivers_[a.receiver.index()].out || !std::isfinite(a.tof_s))
    return false;
  const double degC = std::isfinite(a.temperature_degC) ? a.temperature_degC : medium_.temperature_degC;
  if (degC != speed_degC_) {
    speed_degC_ = degC;
    speed_at_degC_mps_ = speed_mps(medium_, degC) + state_.speed_offset_mps[0];
  }
  static const Pose kStanding;
  PathInput in = path_of(state_, a.beacon, a.receiver, speed_at_degC_mps_ + speed_offset_mps_);
  in.T_map_vehicle = &T_map_vehicle;
  in.delay_s += state_.drift(a.vehicle) * (offset_column_ >= 0 ? a.time_s - epoch_s_ : 0.0);
  if (timing_.ranging == Ranging::kTwoWay) {
    in.delay_s += timing_.turnaround_s;
    in.T_hear_send = &kStanding;
  }
  double walk_sigma_s = 0.0;
  if (state_.attenuation && state_.attenuation->measures(a.amplitude_v)) {
    in.log_amplitude = std::log(a.amplitude_v);
    walk_sigma_s =
        noise_.amplitude_relative_sigma * walk_by_log_amplitude_s(a.amplitude_v, *state_.attenuation);
  }
  const PathOutput out = predict_arrival(in, motion_);
  const double c = in.speed_mps,
               lasting = std::max(1.0, 2.0 * correlated_.time_s / std::max(1e-3, a.time_s - beacon.last_s));
  const double variance_s2 = noise_.tof_sigma_s * noise_.tof_sigma_s + walk_sigma_s * walk_sigma_s +
                             correlated_.sigma_s * correlated_.sigma_s * lasting;
  row.beacon = a.beacon;
  row.receiver = a.receiver;
  row.used = used;
  row.residual_m = c * (a.tof_s - out.tof_s);
  row.weight = 1.0 / (c * c * variance_s2);
  row.by_unknowns.setZero();
  row.by_unknowns.head(pose_unknowns_) = c * out.tof_by_pose.head(pose_unknowns_).transpose();
  if (offset_column_ >= 0) row.by_unknowns[offset_column_] = 1.0;
  if (speed_column_ >= 0) row.by_unknowns[speed_column_] = c * out.tof_by_speed;
  row.by_beacon << 1.0, c * out.tof_by_beacon.transpose();
  row.by_receiver << 1.0, c * out.tof_by_receiver.transpose();
  return std::isfinite(row.residual_m);
}

std::optional<WatchAlarm> Watch::observe_epoch(std::span<const Arrival> arrivals, const Fix& fix) noexcept {
  if (!fix.ok() || arrivals.empty()) return std::nullopt;
  let_speed_drift(fix.time_s);
  epoch_s_ = arrivals.front().time_s;
  const bool known = fix.rejections.size() == arrivals.size();
  row_count_ = 0;
  int used = 0;
  for (std::size_t i = 0; i < arrivals.size() && row_count_ < rows_.size(); ++i) {
    const bool of_fix = !known || fix.rejections[i] == Rejection::kUsed;
    if (!predict(arrivals[i], fix.T_map_vehicle, of_fix, rows_[row_count_])) continue;
    ++row_count_;
    used += of_fix;
  }
  if (used <= unknowns_) return std::nullopt;
  // The adjustment in one step from the fix: N = H' P H + prior, dx = N^-1 H' P v.
  Eigen::Matrix<double, kMostUnknowns, kMostUnknowns> N =
      Eigen::Matrix<double, kMostUnknowns, kMostUnknowns>::Identity() * kWeakPrior;
  Unknowns g = Unknowns::Zero();
  if (offset_column_ >= 0) N(offset_column_, offset_column_) = 1e-9;
  if (speed_column_ >= 0) N(speed_column_, speed_column_) = 1.0 / speed_variance_;
  for (std::size_t i = 0; i < row_count_; ++i) {
    const Row& row = rows_[i];
    if (!row.used) continue;
    N.noalias() += row.weight * row.by_unknowns * row.by_unknowns.transpose();
    g += row.weight * row.residual_m * row.by_unknowns;
  }
  const Eigen::LLT<Eigen::Matrix<double, kMostUnknowns, kMostUnknowns>> factor(N);
  if (factor.info() != Eigen::Success) return std::nullopt;
  inverse_.setIdentity();
  factor.solveInPlace(inverse_);
  const Unknowns step = inverse_ * g;
  for (std::size_t i = 0; i < row_count_; ++i) rows_[i].residual_m -= rows_[i].by_unknowns.dot(step);
  clip_and_gather();
  if (speed_column_ >= 0)
    follow_speed(speed_offset_mps_ + step[speed_column_], inverse_(speed_column_, speed_column_));
  for (auto* members : {&beacons_, &receivers_})
    for (Member& member : *members)
      if (member.used.any || member.left_out.any) update(member, fix.time_s);
  return verdict(fix.time_s);
}

void Watch::follow_speed(double offset_mps, double variance) noexcept {
  // Never farther than what a thermometer may plausibly be off: a beacon that moved is no weather.
  const double farthest_mps = 4.0 * std::sqrt(first_speed_variance_);
  speed_offset_mps_ = std::clamp(offset_mps, -farthest_mps, farthest_mps);
  speed_variance_ = std::clamp(variance, 1e-12, first_speed_variance_);
}

double Watch::limit_of(const Row& row, double variance_m2) const noexcept {
  // Wide enough that what is not let pass any more shows.
  return 2.0 * std::max(beacons_[row.beacon.index()].beta_m, receivers_[row.receiver.index()].beta_m) +
         options_.clip_sigmas * std::sqrt(variance_m2);
}

void Watch::clip_and_gather() noexcept {
  for (auto* members : {&beacons_, &receivers_})
    for (Member& member : *members) {
      if (member.used.any) member.used = Sums{};
      if (member.left_out.any) member.left_out = Sums{};
    }
  for (std::size_t i = 0; i < row_count_; ++i) {
    Row& row = rows_[i];
    const double of_fix = row.weight * row.by_unknowns.dot(inverse_ * row.by_unknowns);
    const double limit_m =
        limit_of(row, (row.used ? cofactor_share(1.0 - of_fix) : 1.0 + of_fix) / row.weight);
    row.residual_m = std::clamp(row.residual_m, -limit_m, limit_m);
    gather(row);
  }
}

void Watch::gather(const Row& row) noexcept {
  const auto add = [&row](Member& member, const Signature& by_change) {
    Sums& sums = row.used ? member.used : member.left_out;
    sums.any = true;
    sums.score += row.weight * row.residual_m * by_change;
    sums.information.noalias() += row.weight * by_change * by_change.transpose();
    sums.by_unknowns.noalias() += row.weight * row.by_unknowns * by_change.transpose();
  };
  add(beacons_[row.beacon.index()], row.by_beacon);
  add(receivers_[row.receiver.index()], row.by_receiver);
}

void Watch::update(Member& member, double time_s) noexcept {
  Signature score = Signature::Zero(), information = Signature::Zero(), cross = Signature::Zero();
  if (member.used.any) {
    const Eigen::Matrix<double, kSignatures, kSignatures> controlled =
        member.used.information - member.used.by_unknowns.transpose() * (inverse_ * member.used.by_unknowns);
    score = member.used.score;
    information = controlled.diagonal().cwiseMax(0.0);
    cross = controlled.col(0);
  }
  if (member.left_out.any) {
    // Arrivals that the fix did not use are predicted by it: their errors and its own add up, and are
    // independent of the residuals of those that it used. a = c' P v ~ N(b A, A + g' N^-1 g).
    const Sums& s = member.left_out;
    const Signature variance =
        s.information.diagonal() + (s.by_unknowns.transpose() * (inverse_ * s.by_unknowns)).diagonal();
    for (int k = 0; k < kSignatures; ++k) {
      if (!(variance[k] > 0.0)) continue;
      const double share = s.information(k, k) / variance[k];
      score[k] += share * s.score[k];
      information[k] += share * s.information(k, k);
      cross[k] += share * s.information(k, 0);
    }
  }
  advance_charts(member, score, information, cross, time_s);
}

void Watch::advance_charts(Member& member, const Signature& score, const Signature& information,
                           const Signature& cross, double time_s) noexcept {
  for (int k = 0; k < kSignatures; ++k)
    for (std::size_t side = 0; side < 2; ++side)
      advance(charts_[member.first_chart + 2 * static_cast<std::size_t>(k) + side], score[k], information[k],
              cross[k], member.beta_m, time_s);
  member.last_s = time_s;
}

void Watch::advance(Chart& chart, double score, double information, double cross, double beta_m,
                    double time_s) noexcept {
  if (!(information > 1e-9)) return;
  const double delta_m = std::min(0.5 * matter_m_, 1.0 / std::sqrt(information));
  const double let_pass = beta_m * std::max(information, std::abs(cross));
  const double gain = std::min(threshold_ / options_.least_steps, delta_m * (chart.sign * score - let_pass) -
                                                                      0.5 * delta_m * delta_m * information);
  const bool begins = chart.sum.value == 0.0;
  if (!chart.sum.add(gain)) {
    forget(chart);
    return;
  }
  if (begins) chart.since_s = time_s;
  chart.score += chart.sign * score;
  chart.information += information;
  alarmed_ = alarmed_ || chart.sum.value > threshold_;
}

std::optional<WatchAlarm> Watch::verdict(double time_s) noexcept {
  if (!alarmed_) return std::nullopt;
  alarmed_ = false;
  // A change shows in the residuals of others too, but nowhere by as many sigmas as in its own chart.
  const Chart* likeliest = nullptr;
  const auto sigmas = [](const Chart& chart) {
    return chart.information > 0.0 ? chart.score / std::sqrt(chart.information) : 0.0;
  };
  for (const Chart& chart : charts_)
    if (chart.sum.value > 0.5 * threshold_ && (likeliest == nullptr || sigmas(chart) > sigmas(*likeliest)))
      likeliest = &chart;
  if (likeliest == nullptr) return std::nullopt;
  WatchAlarm alarm;
  alarm.kind = likeliest->kind;
  const bool of_beacon = alarm.kind == WatchKind::kBeaconLate || alarm.kind == WatchKind::kBeaconMoved;
  if (of_beacon) alarm.beacon = BeaconId(likeliest->member);
  if (!of_beacon) alarm.receiver = ReceiverId(likeliest->member);
  alarm.axis = std::max(0, likeliest->signature - 1);
  alarm.size_m = likeliest->sign * likeliest->score / likeliest->information;
  alarm.sigma_m = 1.0 / std::sqrt(likeliest->information);
  alarm.since_s = likeliest->since_s;
  alarm.time_s = time_s;
  (of_beacon ? beacons_ : receivers_)[likeliest->member].out = true;
  for (Chart& chart : charts_) forget(chart);
  return alarm;
}

std::optional<WatchAlarm> Watch::observe_arrival(const Arrival& arrival, const Pose& T_map_vehicle,
                                                 const PoseCovariance& covariance) noexcept {
  if (covariance.rows() != pose_unknowns_ || covariance.cols() != pose_unknowns_ || offset_column_ >= 0)
    return std::nullopt;
  let_speed_drift(arrival.time_s);
  Row& row = rows_[0];
  if (!predict(arrival, T_map_vehicle, false, row)) return std::nullopt;
  const auto by_pose = row.by_unknowns.head(pose_unknowns_);
  const double by_speed = speed_column_ >= 0 ? row.by_unknowns[speed_column_] : 0.0;
  const double of_speed_m2 = speed_column_ >= 0 ? speed_variance_ * by_speed * by_speed : 0.0;
  const double variance_m2 = 1.0 / row.weight + by_pose.dot(covariance * by_pose) + of_speed_m2;
  const double limit_m = limit_of(row, variance_m2);
  const double innovation_m = std::clamp(row.residual_m, -limit_m, limit_m);
  const auto weigh = [&](Member& member, const Signature& by_change) {
    advance_charts(member, innovation_m / variance_m2 * by_change, by_change.cwiseAbs2() / variance_m2,
                   by_change / variance_m2, arrival.time_s);
  };
  weigh(beacons_[row.beacon.index()], row.by_beacon);
  weigh(receivers_[row.receiver.index()], row.by_receiver);
  if (speed_column_ >= 0) {
    const double gain = speed_variance_ * by_speed / variance_m2;
    follow_speed(speed_offset_mps_ + gain * innovation_m, speed_variance_ * (1.0 - gain * by_speed));
  }
  return verdict(arrival.time_s);
}

}  // namespace octant
