// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/space/space_filter.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "models/localizers/common/correlated_arrivals.h"
#include "models/physics/plane.h"

namespace octant {
namespace {

constexpr Eigen::Index kMostCalibrated = 200;  ///< number of parameters that the smoother follows
constexpr std::size_t kRecent = 20,
                      kLost =
                          14;  ///< number of rejections among the latest arrivals at which the track is lost

bool is_candidate(const SpaceRange& r) {
  return r.rejection == Rejection::kUsed || r.rejection == Rejection::kLate ||
         r.rejection == Rejection::kEarly;
}

}  // namespace

SpaceFilter::SpaceFilter(SpaceRanges& ranges, const SpaceSetting& setting, std::size_t first,
                         const SpaceStart& start, double density)
    : ranges_(ranges), setting_(setting), first_(first), density_(density) {
  const Eigen::Index n = setting.size;
  const Eigen::Index p = setting.calibration.covariance().rows();
  now_.x = Eigen::VectorXd::Zero(n);
  now_.x.head<3>() = start.p_map_m;
  now_.P = Eigen::MatrixXd::Zero(n, n);
  now_.P.topLeftCorner<3, 3>() = start.covariance_m2;
  now_.P.diagonal().segment<3>(3).setConstant(square(setting.options.speed_sigma_mps));
  now_.P.diagonal().tail(n - 6).setConstant(square(setting.bias_sigma_m));
  now_.M = Eigen::MatrixXd::Zero(n, p <= kMostCalibrated ? p : 0);
  start_ = now_;
  height_m_ = start.p_map_m.z();
}

std::size_t SpaceFilter::filter(std::size_t end) {
  steps_.clear();
  now_ = start_;
  // The accuracy of the start serves the first rejections only, because its arrivals count again.
  if (!about_.empty()) now_.P.topLeftCorner<3, 3>() = square(setting_.extent_m) * Eigen::Matrix3d::Identity();
  likelihood_ = 0.0;
  since_held_s_ = INFINITY;
  std::vector<bool> recent;
  for (std::size_t k = first_; k < end; ++k) {
    const double dt = k == first_ ? 0.0 : ranges_.instants[k].time_s - ranges_.instants[k - 1].time_s;
    if (dt > setting_.options.max_gap_s) return k;
    SpaceStep step;
    step.F = predict(dt);
    step.predicted = now_;
    hold_within_site(dt);
    for (std::size_t i = ranges_.instants[k].first; i < ranges_.instants[k].last; ++i)
      if (is_candidate(ranges_.all[i])) recent.push_back(!update(ranges_.all[i], k - first_));
    step.updated = now_;
    steps_.push_back(std::move(step));
    if (recent.size() > kRecent)
      recent.erase(recent.begin(), recent.end() - static_cast<std::ptrdiff_t>(kRecent));
    if (static_cast<std::size_t>(std::ranges::count(recent, true)) >= kLost) return k + 1;
  }
  return end;
}

void SpaceFilter::smooth() {
  if (steps_.empty()) return;
  steps_.back().smoothed = steps_.back().updated;
  for (std::size_t k = steps_.size() - 1; k-- > 0;) {
    const SpaceBelief &here = steps_[k].updated, &ahead = steps_[k + 1].predicted,
                      &told = steps_[k + 1].smoothed;
    const Eigen::MatrixXd G = ahead.P.ldlt().solve(steps_[k + 1].F * here.P).transpose();
    SpaceBelief& out = steps_[k].smoothed;
    out.x = here.x + G * (told.x - ahead.x);
    out.P = here.P + G * (told.P - ahead.P) * G.transpose();
    out.M = here.M + G * (told.M - ahead.M);
  }
  linearise_at(steps_);
  about_own_ = true;
}

double SpaceFilter::iterate(std::size_t end) {
  constexpr int kRounds = 3;
  bool whole = true;
  for (int round = 0; round < kRounds; ++round) {
    whole = filter(end) == end && whole;
    smooth();
  }
  return whole ? likelihood_ : -INFINITY;
}

bool SpaceFilter::widen_tails(double power) {
  constexpr double kWindow = 0.25;  ///< in correlation times, within which a lasting error hardly changes
  const double window_s = kWindow * setting_.bias_time_s;
  bool changed = false;
  std::vector<double> near_m;
  for (std::vector<TrackError>& errors : errors_by_beacon())
    for (std::size_t i = 0, first = 0, last = 0; i < errors.size(); ++i) {
      while (errors[first].time_s < errors[i].time_s - window_s) ++first;
      while (last < errors.size() && errors[last].time_s <= errors[i].time_s + window_s) ++last;
      near_m.clear();
      for (std::size_t j = first; j < last; ++j) near_m.push_back(errors[j].error_m);
      const auto middle = near_m.begin() + static_cast<std::ptrdiff_t>(near_m.size() / 2);
      std::ranges::nth_element(near_m, middle);
      double& widening = errors[i].range->widening;
      const double before = widening;
      widening = std::pow(std::max(1.0, std::abs(*middle) / (kTailSigmas * setting_.bias_sigma_m)), power);
      changed = changed || std::abs(widening - before) > kTailChanged * before;
    }
  return changed;
}

std::vector<std::vector<SpaceFilter::TrackError>> SpaceFilter::errors_by_beacon() {
  std::vector<std::vector<TrackError>> errors(setting_.bias.size());
  for (std::size_t k = 0; k < steps_.size(); ++k)
    for (std::size_t i = ranges_.instants[first_ + k].first; i < ranges_.instants[first_ + k].last; ++i) {
      SpaceRange& r = ranges_.all[i];
      if (!is_candidate(r) || setting_.bias[r.arrival.beacon.index()] < 0) continue;
      const double length_m = (steps_[k].smoothed.x.head<3>() - r.p_beacon_m).norm();
      errors[r.arrival.beacon.index()].push_back(
          {ranges_.instants[first_ + k].time_s, r.distance.range_m - length_m, &r});
    }
  return errors;
}

void SpaceFilter::linearise_at(const std::vector<SpaceStep>& steps) {
  about_own_ = false;
  about_.clear();
  for (const SpaceStep& s : steps) about_.push_back(s.smoothed.x);
}

Eigen::MatrixXd SpaceFilter::predict(double dt) {
  const Eigen::Index n = setting_.size;
  Eigen::MatrixXd F = Eigen::MatrixXd::Identity(n, n);
  F.topLeftCorner<3, 3>().setIdentity();
  F.block<3, 3>(0, 3) = dt * Eigen::Matrix3d::Identity();
  const double kept = std::exp(-dt / setting_.bias_time_s);
  F.diagonal().tail(n - 6).setConstant(kept);
  now_.x = F * now_.x;
  now_.P = F * now_.P * F.transpose();
  now_.M = F * now_.M;
  for (Eigen::Index i = 0; i < 3; ++i) {
    now_.P(i, i) += density_ * dt * dt * dt / 3;
    now_.P(i, i + 3) += density_ * dt * dt / 2;
    now_.P(i + 3, i) += density_ * dt * dt / 2;
    now_.P(i + 3, i + 3) += density_ * dt;
  }
  now_.P.diagonal().tail(n - 6).array() += square(setting_.bias_sigma_m) * (1 - kept * kept);
  return F;
}

/// Keeps the vehicle within the site: otherwise a height that coplanar beacons hardly determine would drift
/// away with the velocity.
void SpaceFilter::hold_within_site(double dt) {
  since_held_s_ += dt;
  if (dt > 0 && since_held_s_ < 1.0) return;
  since_held_s_ = 0.0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double mean = i == 2 ? height_m_ : setting_.plane.centre_m[i];
    const double sigma = i == 2 ? 0.25 * setting_.reach_m : setting_.reach_m;
    Eigen::VectorXd H = Eigen::VectorXd::Unit(setting_.size, i);
    correct(H, mean - now_.x[i], square(sigma), Eigen::VectorXd::Zero(now_.M.cols()));
  }
}

void SpaceFilter::correct(const Eigen::VectorXd& H, double innovation, double variance,
                          const Eigen::VectorXd& by_calibration) {
  const Eigen::VectorXd PH = now_.P * H;
  const double S = H.dot(PH) + variance;
  const Eigen::VectorXd K = PH / S;
  now_.x += K * innovation;
  now_.P -= K * PH.transpose();
  now_.P = (0.5 * (now_.P + now_.P.transpose())).eval();
  now_.M += K * (by_calibration.transpose() - H.transpose() * now_.M);
}

/// @return true if the arrival agrees
bool SpaceFilter::update(SpaceRange& r, std::size_t k) {
  const bool again = k < about_.size();
  const Eigen::Vector3d p = again ? Eigen::Vector3d(about_[k].head<3>()) : Eigen::Vector3d(now_.x.head<3>());
  const Eigen::Vector3d d = p - r.p_beacon_m;
  const double length = std::max(1e-9, d.norm());
  const Eigen::Vector3d u = d / length;
  Eigen::VectorXd H = Eigen::VectorXd::Zero(setting_.size);
  H.head<3>() = u;
  const int bias = setting_.bias[r.arrival.beacon.index()];
  if (bias >= 0) H[bias] = r.widening;
  const double innovation = r.distance.range_m - length - H.dot(now_.x) + u.dot(p);
  const double own_m2 = H.dot(now_.P * H), S = own_m2 + r.variance_m2, squares = square(innovation) / S;
  const double limit = square(setting_.options.rejection_sigmas);
  likelihood_ -= 0.5 * (std::min(squares, limit) + std::log(S));
  bool agrees = squares <= limit;
  if (agrees && again && about_own_) {
    // A state that is wider than the gate of a range, as at the start, agrees with any. The smoothed track
    // does not.
    const double range_m2 = r.variance_m2 + (bias >= 0 ? square(r.widening * setting_.bias_sigma_m) : 0.0);
    agrees = own_m2 < limit * range_m2 || square(r.distance.range_m - length) <= limit * range_m2;
  }
  r.rejection = agrees ? Rejection::kUsed : innovation > 0 ? Rejection::kLate : Rejection::kEarly;
  if (r.rejection != Rejection::kUsed) return false;
  correct(H, innovation, r.variance_m2, by_calibration(r, u));
  return true;
}

/// Derivative of range minus distance by the calibrated parameters.
Eigen::VectorXd SpaceFilter::by_calibration(const SpaceRange& r, const Eigen::Vector3d& u) const {
  Eigen::VectorXd by = Eigen::VectorXd::Zero(now_.M.cols());
  if (by.size() == 0) return by;
  ObservationRow row;
  row.has_shared = true;
  row.beacon = r.arrival.beacon;
  row.receiver = r.arrival.receiver;
  row.by_beacon = u.transpose();
  row.by_receiver.setZero();
  row.by_attenuation.setZero();
  row.by(kByDelay) = -r.distance.gain_mps;
  row.by(kBySpeed) = r.distance.by_speed_s();
  setting_.calibration.for_each_coupling(row, [&](int at, double derivative) { by[at] += derivative; });
  return by;
}

}  // namespace octant
