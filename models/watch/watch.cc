// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/watch/watch.h"

#include <algorithm>
#include <cmath>

#include "models/physics/measurement.h"
#include "models/physics/plane.h"
#include "models/support/enum_names.h"

namespace octant {
namespace {

constexpr double kMonth_s = 30.0 * 24.0 * 3600.0;
constexpr double kHour_s = 3600.0;
/// Least time and distance of a block, longer than multipath is correlated. At rest a block ends after twice
/// this time.
constexpr double kBlock_s = 4.0, kBlock_m = 2.0;
/// Distance between different places.
constexpr double kPlace_m = 2.0;
constexpr std::size_t kMostBeacons = 16;  ///< beacons tested jointly, those received last
/// Sigma of the speed if the temperature is not measured: five degrees.
constexpr double kUncheckedAir_mps = 3.0;
/// Least prior sigma of a position; no survey is better.
constexpr double kSurvey_m = 1e-3;
/// Change to detect, as a share of the tolerance, and without a tolerance.
constexpr double kToleranceShare = 0.25, kMatter_m = 0.015;
/// The filter follows persistent residuals up to several gates, beyond which it would not be linear.
constexpr double kGateSigmas = 4.0, kFollowedGates = 3.0;
constexpr double kForgetAcceptance = 1.0 / 50.0, kLeastAcceptance = 0.5;
/// Prior sigma of a fix whose arrivals are used again.
constexpr double kFix_m = 0.3;
/// Factor on the covariance of a tracker's pose, which may be optimistic.
constexpr double kStartVariance = 4.0;

double let_pass_of(const Deployment& d, const WatchOptions& options) {
  const double tolerated = d.tolerance.beacon_m ? kToleranceShare * *d.tolerance.beacon_m : kMatter_m;
  return 0.5 * options.matter_m.value_or(tolerated);
}

std::vector<Eigen::Vector3d> places_of(const Deployment& d) {
  std::vector<Eigen::Vector3d> places;
  for (const DeploymentBeacon& b : d.beacons) places.push_back(b.position_m);
  return places;
}

std::size_t tested_beacons(const Deployment& d) {
  return std::min(kMostBeacons, static_cast<std::size_t>(std::ranges::count_if(d.beacons, [](const auto& b) {
                    return b.status != BeaconStatus::kUndetermined;
                  })));
}

std::size_t receivers_of(const Deployment& d, VehicleId vehicle) {
  return static_cast<std::size_t>(
      std::ranges::count_if(d.receivers, [vehicle](const auto& r) { return r.vehicle == vehicle; }));
}

/// Threshold for the rate of false alarms, with one hypothesis for each member and form of change, and one
/// decision for each block.
double threshold_of(const Deployment& d, const WatchOptions& options, VehicleId vehicle) {
  const double hypotheses =
      static_cast<double>(std::size(kChangeForms) * (tested_beacons(d) + receivers_of(d, vehicle)));
  return std::log(std::max(2.0, hypotheses * kMonth_s / kBlock_s / options.false_alarms_a_month));
}

double speed_variance_of(const Deployment& d) {
  const double unchecked_mps = d.medium.model == MediumModel::kConstant ? 0.0 : kUncheckedAir_mps;
  return d.speed_sigma_mps * d.speed_sigma_mps + unchecked_mps * unchecked_mps;
}

ChangeMatrix prior_of(const Eigen::Matrix3d& place_m2, double delay_m) {
  ChangeMatrix prior = kSurvey_m * kSurvey_m * ChangeMatrix::Identity();
  prior(0, 0) += delay_m * delay_m;
  prior.bottomRightCorner<3, 3>() += place_m2;
  return prior;
}

}  // namespace

const char* to_string(WatchKind kind) {
  static constexpr auto kNames = enum_names<WatchKind>("beacon_late", "beacon_moved", "beacon_silent",
                                                       "receiver_late", "receiver_moved");
  return kNames[kind];
}

bool Watch::Recent::agrees(double residual, double within_m) const {
  const auto with =
      std::ranges::count_if(std::span(residual_m).first(std::min(count, kCount)),
                            [&](double other) { return std::abs(other - residual) < within_m; });
  return with > static_cast<std::ptrdiff_t>(kCount / 2);
}

Watch::Watch(const Deployment& d, const WatchOptions& options, VehicleId vehicle)
    : motion_(d.motion),
      medium_(d.medium),
      timing_(d.timing),
      noise_(d.noise),
      correlated_(d.correlated_noise),
      state_(shared_state(d)),
      options_(options),
      let_pass_m_(let_pass_of(d, options)),
      threshold_(threshold_of(d, options, vehicle)),
      first_speed_variance_(speed_variance_of(d)),
      recent_(d.beacons.size() * d.receivers.size()),
      evidence_(tested_beacons(d), receivers_of(d, vehicle), threshold_, let_pass_m_),
      reception_(places_of(d), threshold_),
      pose_(d.motion, first_speed_variance_ > 0.0, d.timing.clock == Clock::kCycleOffset,
            evidence_.columns()) {
  by_change_.setZero(static_cast<Eigen::Index>(evidence_.columns()));
  beacon_of_member_.resize(tested_beacons(d));
  const double c = d.speed_mps(medium_.temperature_degC);
  const auto late_m = [&](double delay_sigma_s) {
    return c * std::hypot(delay_sigma_s, correlated_.pair_sigma_s);
  };
  for (const DeploymentBeacon& b : d.beacons)
    beacons_.push_back({.usable = b.status != BeaconStatus::kUndetermined,
                        .prior = prior_of(b.covariance_m2, late_m(b.delay_sigma_s))});
  for (const DeploymentReceiver& r : d.receivers) {
    Watched receiver{.usable = r.vehicle == vehicle,
                     .prior = prior_of(r.sigma_m.cwiseAbs2().asDiagonal(), late_m(r.delay_sigma_s))};
    if (receiver.usable) {
      receiver.member = beacon_of_member_.size() + receiver_of_member_.size();
      receiver_of_member_.emplace_back(receivers_.size());
    }
    receivers_.push_back(receiver);
  }
  restart();
}

void Watch::restart() noexcept {
  for (Watched& beacon : beacons_) {
    beacon.out = false;
    beacon.member = kNoMember;
    beacon.received = 0;
  }
  std::ranges::fill(beacon_of_member_, BeaconId());
  for (Watched& receiver : receivers_) {
    receiver.out = false;
    if (receiver.member != kNoMember) evidence_.set_prior(receiver.member, receiver.prior);
  }
  std::ranges::fill(recent_, Recent{});
  evidence_.restart();
  reception_.restart();
  pose_.set_speed(0.0, first_speed_variance_);
  following_ = block_open_ = false;
  last_place_m_.reset();
}

void Watch::leave_out(BeaconId id) noexcept {
  if (!id.valid() || id.index() >= beacons_.size()) return;
  beacons_[id.index()].out = true;
  evidence_.restart();
  block_open_ = false;
}

bool Watch::is_watched(const Arrival& a) const {
  return a.beacon.valid() && a.beacon.index() < beacons_.size() && a.receiver.valid() &&
         a.receiver.index() < receivers_.size() && beacons_[a.beacon.index()].usable &&
         receivers_[a.receiver.index()].usable && std::isfinite(a.tof_s) && std::isfinite(a.time_s);
}

/// Column of a beacon in the joint test. A new beacon gets that of the beacon received longest ago.
std::size_t Watch::member_of(BeaconId id) noexcept {
  Watched& beacon = beacons_[id.index()];
  beacon.received = ++arrivals_;
  if (beacon.member != kNoMember) return beacon.member;
  std::size_t at = 0;
  const auto last = [this](std::size_t m) {
    return beacon_of_member_[m].valid() ? beacons_[beacon_of_member_[m].index()].received : 0;
  };
  for (std::size_t m = 1; m < beacon_of_member_.size(); ++m)
    if (last(m) < last(at)) at = m;
  if (beacon_of_member_[at].valid()) beacons_[beacon_of_member_[at].index()].member = kNoMember;
  beacon_of_member_[at] = id;
  beacon.member = at;
  evidence_.forget(at);
  evidence_.set_prior(at, beacon.prior);
  pose_.forget_change(static_cast<Eigen::Index>(4 * at));
  return at;
}

bool Watch::predict(const Arrival& a, Prediction& out) noexcept {
  const double degC = std::isfinite(a.temperature_degC) ? a.temperature_degC : medium_.temperature_degC;
  if (degC != speed_degC_) {
    speed_degC_ = degC;
    speed_at_degC_mps_ = speed_mps(medium_, degC) + state_.speed_offset_mps[0];
  }
  static const Pose kStanding;
  PathInput in = path_of(state_, a.beacon, a.receiver, speed_at_degC_mps_ + pose_.speed_offset_mps());
  in.T_map_vehicle = &pose_.pose();
  in.delay_s += state_.drift(a.vehicle) * (pose_.offset_column() >= 0 ? a.time_s - epoch_s_ : 0.0);
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
  const PathOutput path = predict_arrival(in, motion_);
  Watched& beacon = beacons_[a.beacon.index()];
  const double c = in.speed_mps,
               lasting = std::max(1.0, 2.0 * correlated_.time_s / std::max(1e-3, a.time_s - beacon.last_s));
  beacon.last_s = a.time_s;
  out.residual_m = c * (a.tof_s - path.tof_s) - pose_.offset_m();
  out.variance_m2 = c * c *
                    (noise_.tof_sigma_s * noise_.tof_sigma_s + walk_sigma_s * walk_sigma_s +
                     correlated_.sigma_s * correlated_.sigma_s * lasting);
  by_unknowns_.setZero();
  by_unknowns_.head(pose_.pose_unknowns()) = c * path.tof_by_pose.head(pose_.pose_unknowns()).transpose();
  if (pose_.offset_column() >= 0) by_unknowns_[pose_.offset_column()] = 1.0;
  if (pose_.speed_column() >= 0) by_unknowns_[pose_.speed_column()] = c * path.tof_by_speed;
  by_change_.setZero();
  const auto of_beacon = static_cast<Eigen::Index>(4 * beacon.member),
             of_receiver = static_cast<Eigen::Index>(4 * receivers_[a.receiver.index()].member);
  by_change_.segment<4>(of_beacon) << 1.0, c * path.tof_by_beacon.transpose();
  by_change_.segment<4>(of_receiver) << 1.0, c * path.tof_by_receiver.transpose();
  pose_.add_estimate(by_unknowns_, by_change_);
  return std::isfinite(out.residual_m) && by_change_.allFinite();
}

void Watch::observe(const Arrival& a, bool may_correct) noexcept {
  static_cast<void>(member_of(a.beacon));
  Prediction prediction;
  if (!predict(a, prediction)) return;
  const double variance_m2 = prediction.variance_m2 + pose_.variance(by_unknowns_),
               gate_m = kGateSigmas * std::sqrt(variance_m2 + let_pass_m_ * let_pass_m_);
  const bool within = std::abs(prediction.residual_m) < gate_m;
  acceptance_ += kForgetAcceptance * ((within ? 1.0 : 0.0) - acceptance_);
  Recent& recent = recent_[a.beacon.index() * receivers_.size() + a.receiver.index()];
  const bool lasts = recent.agrees(prediction.residual_m, gate_m);
  recent.residual_m[recent.count++ % Recent::kCount] = prediction.residual_m;
  if (!block_open_) {
    block_open_ = true;
    block_begin_s_ = a.time_s;
    block_way_m_ = 0.0;
    evidence_.begin_block(a.time_s);
  }
  if ((within || lasts) && acceptance_ > kLeastAcceptance && a.time_s - block_begin_s_ < 2.0 * kBlock_s)
    evidence_.add(by_change_, prediction.residual_m, variance_m2);
  // A filter that used only the smaller of persistent residuals would follow their noise.
  const bool follows = within || (lasts && std::abs(prediction.residual_m) < kFollowedGates * gate_m);
  if (follows && may_correct) pose_.correct(by_unknowns_, by_change_, prediction.residual_m, variance_m2);
}

void Watch::travel(double distance_m, double time_s) noexcept {
  block_way_m_ += distance_m;
  place_way_m_ += distance_m;
  const double hours = std::clamp((time_s - last_speed_s_) / kHour_s, 0.0, 24.0),
               drift = options_.speed_drift_mps_per_hour;
  pose_.let_speed_drift(drift * drift * hours, first_speed_variance_);
  last_speed_s_ = time_s;
  if (!block_open_ || evidence_.is_testing() || time_s - block_begin_s_ < kBlock_s || block_way_m_ < kBlock_m)
    return;
  evidence_.end_block();
  block_open_ = false;
}

std::optional<WatchAlarm> Watch::observe_epoch(std::span<const Arrival> arrivals, const Fix& fix) noexcept {
  for (const Arrival& a : arrivals)
    if (is_watched(a)) reception_.receive(a.beacon);
  if (!fix.ok() || arrivals.empty() || fix.covariance.rows() != pose_.pose_unknowns()) return std::nullopt;
  const bool known = fix.rejections.size() == arrivals.size();
  const auto in_use = [&](std::size_t i) {
    return is_watched(arrivals[i]) && !is_out(arrivals[i].beacon) && !is_out(arrivals[i].receiver);
  };
  const auto used = [&](std::size_t i) { return !known || fix.rejections[i] == Rejection::kUsed; };
  int count = 0;
  for (std::size_t i = 0; i < arrivals.size(); ++i) count += in_use(i) && used(i);
  if (count <= pose_.pose_unknowns() + (pose_.offset_column() >= 0)) return std::nullopt;
  PoseCovariance weak = fix.covariance;
  weak.diagonal().array() += kFix_m * kFix_m;
  pose_.start(fix.T_map_vehicle, weak);
  acceptance_ = 1.0;
  epoch_s_ = arrivals.front().time_s;
  travel(last_place_m_ ? (fix.T_map_vehicle.translation_m - *last_place_m_).norm() : 0.0, fix.time_s);
  last_place_m_ = fix.T_map_vehicle.translation_m;
  for (std::size_t i = 0; i < arrivals.size(); ++i)
    if (in_use(i) && used(i)) observe(arrivals[i], true);
  for (std::size_t i = 0; i < arrivals.size(); ++i)
    if (in_use(i) && !used(i)) observe(arrivals[i], false);
  std::optional<WatchAlarm> alarm;
  for (std::size_t i = 0; i < arrivals.size() && !alarm; ++i) alarm = verdict(fix.time_s);
  return alarm;
}

void Watch::start(const Pose& T_map_vehicle, const PoseCovariance& covariance) noexcept {
  if (covariance.rows() != pose_.pose_unknowns() || pose_.offset_column() >= 0) return;
  pose_.start(T_map_vehicle, kStartVariance * covariance);
  following_ = true;
  block_open_ = false;
  acceptance_ = 1.0;
}

void Watch::move(const OdometryObservation& motion) noexcept {
  if (!following_) return;
  pose_.move(motion.T_before_after, {.distance_m2 = square(motion.distance_sigma_m),
                                     .heading_rad2 = square(motion.heading_sigma_rad)});
  travel(motion.T_before_after.translation_m.norm(), now_s_);
}

std::optional<WatchAlarm> Watch::observe_arrival(const Arrival& a) noexcept {
  if (!is_watched(a)) return std::nullopt;
  reception_.receive(a.beacon);
  now_s_ = a.time_s;
  if (!following_) return std::nullopt;
  if (!is_out(a.beacon) && !is_out(a.receiver)) observe(a, true);
  if (acceptance_ < kLeastAcceptance) following_ = false;
  return verdict(a.time_s);
}

std::optional<WatchAlarm> Watch::verdict(double time_s) noexcept {
  if (const auto change = evidence_.evaluate()) return alarm_of(*change, time_s);
  if (place_way_m_ < kPlace_m) return std::nullopt;
  place_way_m_ = 0.0;
  const auto silent = reception_.leave_place(pose_.pose().translation_m, time_s);
  if (!silent || !beacons_[silent->index()].usable || is_out(*silent)) return std::nullopt;
  WatchAlarm alarm;
  alarm.kind = WatchKind::kBeaconSilent;
  alarm.beacon = *silent;
  alarm.since_s = reception_.since_s(*silent);
  alarm.time_s = time_s;
  return alarm;
}

WatchAlarm Watch::alarm_of(const FoundChange& change, double time_s) noexcept {
  WatchAlarm alarm;
  const bool is_beacon = change.member < beacon_of_member_.size();
  const Eigen::Vector3d shift_m = change.size_m.tail<3>(),
                        sigma_m = change.covariance_m2.diagonal().tail<3>().cwiseSqrt();
  const bool late = change.form == ChangeForm::kLate;
  if (is_beacon) {
    alarm.kind = late ? WatchKind::kBeaconLate : WatchKind::kBeaconMoved;
    alarm.beacon = beacon_of_member_[change.member];
    beacons_[alarm.beacon.index()].out = true;
  } else {
    alarm.kind = late ? WatchKind::kReceiverLate : WatchKind::kReceiverMoved;
    alarm.receiver = receiver_of_member_[change.member - beacon_of_member_.size()];
    receivers_[alarm.receiver.index()].out = true;
  }
  if (!late) {
    (shift_m.cwiseAbs() - 2.0 * sigma_m).maxCoeff(&alarm.axis);
    alarm.shift_m = shift_m;
  }
  const int at = late ? 0 : 1 + alarm.axis;
  alarm.size_m = change.size_m[at];
  alarm.sigma_m = std::sqrt(change.covariance_m2(at, at));
  alarm.since_s = change.since_s;
  alarm.time_s = time_s;
  evidence_.restart();
  block_open_ = false;
  pose_.remove_change(static_cast<Eigen::Index>(4 * change.member), change.size_m);
  return alarm;
}

}  // namespace octant
