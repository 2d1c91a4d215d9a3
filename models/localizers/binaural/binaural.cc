// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/binaural/binaural.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "models/localizers/common/arrival_range.h"
#include "models/physics/plane.h"
#include "models/support/observed.h"

namespace octant {
namespace {

constexpr double kRounding_m = 1e-9;  // rounding of the geometry; used if the deployment states no noise
constexpr int kSteps = 20;

Eigen::Matrix2d rotation(double angle_rad) { return Eigen::Rotation2Dd(angle_rad).toRotationMatrix(); }

}  // namespace

std::optional<Eigen::Vector2d> intersect_circles(const Eigen::Vector2d& p1_m, double r1_m,
                                                 const Eigen::Vector2d& p2_m, double r2_m,
                                                 const Eigen::Vector2d& facing) noexcept {
  // Eq. 3-6 solve for y = M x + N, the common chord of the circles, and divide by y2 - y1, which is zero for
  // the paper's own receivers. The same chord is computed in the receivers' frame, along and perpendicular to
  // their baseline.
  const Eigen::Vector2d chord = p2_m - p1_m;
  const double b = chord.norm();
  if (!(b > 1e-9)) return std::nullopt;
  const Eigen::Vector2d along = chord / b;
  Eigen::Vector2d ahead = left_of(along);
  if (ahead.dot(facing) < 0) ahead = -ahead;  // the other intersection lies behind the receivers
  const double x = (r1_m - r2_m) * (r1_m + r2_m) / (2 * b) + b / 2;
  const double y_squared = (r1_m - x) * (r1_m + x);
  if (!(y_squared > 0)) return std::nullopt;
  return p1_m + x * along + std::sqrt(y_squared) * ahead;
}

std::optional<double> level_range_m(double range_m, double height_m) noexcept {
  const double squared = (range_m - height_m) * (range_m + height_m);
  if (!(range_m > 0 && squared > 0)) return std::nullopt;
  return std::sqrt(squared);
}

Binaural::Binaural(const Deployment& deployment, const BinauralOptions& options)
    : Localizer(deployment), deployment_(deployment), options_(options), range_errors_(deployment) {
  const auto roles = binaural_roles(deployment, options);
  if (!roles) return;
  roles_ = *roles;
  const BinauralRoles& r = *roles_;
  const std::array<BeaconId, 4> beacons = {r.transmitter2, r.transmitter2, r.left2, r.right2};
  const std::array<ReceiverId, 4> receivers = {r.left1, r.right1, r.transmitter1, r.transmitter1};
  const Eigen::Matrix3d level = (Eigen::AngleAxisd(options.pitch_rad, Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(options.roll_rad, Eigen::Vector3d::UnitX()))
                                    .toRotationMatrix();
  for (std::size_t i = 0; i < 4; ++i) {
    links_[i].pair.beacon = beacons[i];
    links_[i].pair.receiver = receivers[i];
    links_[i].p_beacon_m = deployment.beacons[beacons[i].index()].position_m;
    links_[i].p_receiver_m = level * deployment.receivers[receivers[i].index()].position_m +
                             Eigen::Vector3d(0, 0, options.height_difference_m);
  }
}

void Binaural::locate_known(const Observations& observations, Fix& fix) noexcept {
  collect(observations, fix);
  for (const Link& link : links_)
    if (link.pair.arrivals == 0) return;  // kTooFewArrivals
  PlanarPose pose;
  fix.status = closed_form(pose);
  if (fix.ok() && !within_beam(pose)) {
    fix.status = FixStatus::kPoorGeometry;
    for (Rejection& r : fix.rejections)
      if (r == Rejection::kUsed) r = Rejection::kOutOfRange;
  }
  if (fix.ok()) fix.status = adjust(pose, fix);
  if (!fix.ok()) return;
  fix.T_map_vehicle = Pose::planar(pose.p_m.x(), pose.p_m.y(), pose.heading_rad);
  count_rejections(fix);
}

/// Assigns the arrivals to the four links and resets the fix.
void Binaural::collect(const Observations& observations, Fix& fix) noexcept {
  begin_fix(observations.arrivals, fix);
  fix.covariance.setZero(3, 3);
  fix.vehicle = options_.vehicle;
  fix.rejections.assign(observations.arrivals.size(), Rejection::kNotNeeded);
  for (Link& link : links_) link.pair = {.beacon = link.pair.beacon, .receiver = link.pair.receiver};
  if (!roles_) return;
  for (std::size_t i = 0; i < observations.arrivals.size(); ++i) {
    const Arrival& arrival = observations.arrivals[i];
    if (arrival.beacon.valid() && arrival.beacon.index() < deployment_.beacons.size() &&
        deployment_.beacons[arrival.beacon.index()].status == BeaconStatus::kUndetermined)
      fix.rejections[i] = Rejection::kBeaconUnusable;
    for (Link& link : links_) {
      PairRange& pair = link.pair;
      if (arrival.beacon != pair.beacon || arrival.receiver != pair.receiver) continue;
      const ArrivalRange range = arrival_range(arrival, deployment_);
      if (!(range.range_m > 0) || !std::isfinite(range.range_m)) {
        fix.rejections[i] = Rejection::kOutOfRange;
        continue;
      }
      ++pair.arrivals;
      pair.range_m += (range.range_m - pair.range_m) / pair.arrivals;
      pair.gain_mps += (range.speed_mps - pair.gain_mps) / pair.arrivals;
      fix.rejections[i] = Rejection::kUsed;
    }
  }
  for (Link& link : links_) {
    PairRange& pair = link.pair;
    if (pair.arrivals == 0) continue;
    pair.sigma_m = pair.gain_mps * deployment_.noise.tof_sigma_s / std::sqrt(pair.arrivals);
    pair.by_speed_s = pair.range_m / pair.gain_mps;
  }
}

FixStatus Binaural::closed_form(PlanarPose& pose) const noexcept {
  std::array<double, 4> r{};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto level =
        level_range_m(links_[i].pair.range_m, links_[i].p_beacon_m.z() - links_[i].p_receiver_m.z());
    if (!level) return FixStatus::kPoorGeometry;
    r[i] = *level;
  }
  // eq. 3-6 on each robot: the other robot's transmitter in its frame.
  const auto p_t2_vehicle = intersect_circles(links_[0].p_receiver_m.head<2>(), r[0],
                                              links_[1].p_receiver_m.head<2>(), r[1], roles_->facing1);
  const auto p_t1_map = intersect_circles(links_[2].p_beacon_m.head<2>(), r[2],
                                          links_[3].p_beacon_m.head<2>(), r[3], options_.facing_map);
  if (!p_t2_vehicle || !p_t1_map) return FixStatus::kPoorGeometry;

  // eq. 7, 8: angles at which each transmitter sees the other. The paper measures one of them from the
  // lateral axis and the other from the forward axis; otherwise its special cases are inconsistent. Here both
  // are bearings from x.
  const double alpha1 = angle_of(*p_t2_vehicle - links_[2].p_receiver_m.head<2>());
  const double alpha2 = angle_of(*p_t1_map - links_[0].p_beacon_m.head<2>());
  // eq. 9: the same ray seen from its two ends differs by half a turn and by the orientation.
  pose.heading_rad = wrap_angle(alpha2 + std::numbers::pi - alpha1);
  pose.p_m = *p_t1_map - rotation(pose.heading_rad) * links_[2].p_receiver_m.head<2>();
  return FixStatus::kOk;
}

bool Binaural::within_beam(const PlanarPose& pose) const noexcept {
  const Eigen::Matrix2d R = rotation(pose.heading_rad);
  const Eigen::Vector2d sight =
      pose.p_m + R * links_[2].p_receiver_m.head<2>() - links_[0].p_beacon_m.head<2>();
  const double off2 = std::abs(wrap_angle(angle_of(sight) - angle_of(options_.facing_map)));
  const double off1 = std::abs(wrap_angle(angle_of(-sight) - angle_of(R * roles_->facing1)));
  return std::max(off1, off2) <= options_.beam.limit_rad && std::min(off1, off2) <= options_.beam.both_rad;
}

FixStatus Binaural::adjust(PlanarPose& pose, Fix& fix) noexcept {
  Eigen::Vector4d noise_m;
  for (int i = 0; i < 4; ++i)
    noise_m[i] = std::max(links_[static_cast<std::size_t>(i)].pair.sigma_m, kRounding_m);
  const Eigen::Vector4d weight = noise_m.cwiseAbs2().cwiseInverse();
  Eigen::Matrix<double, 4, 3> J, toward;
  Eigen::Matrix<double, 3, 4> gain;
  Eigen::Vector4d residual;
  bool converged = false;
  for (int step = 0; step < kSteps && !converged; ++step) {
    for (int i = 0; i < 4; ++i) {
      const Link& link = links_[static_cast<std::size_t>(i)];
      const Eigen::Vector2d lever = rotation(pose.heading_rad) * link.p_receiver_m.head<2>();
      Eigen::Vector3d v(pose.p_m.x() + lever.x(), pose.p_m.y() + lever.y(), link.p_receiver_m.z());
      v -= link.p_beacon_m;
      const double d = std::max(v.norm(), kRounding_m);
      toward.row(i) = v.transpose() / d;
      J.row(i) << v.x() / d, v.y() / d, (v.y() * lever.x() - v.x() * lever.y()) / d;
      residual[i] = link.pair.range_m - d;
    }
    const Eigen::Matrix3d N = J.transpose() * weight.asDiagonal() * J;
    const ObservedState<Eigen::Matrix3d> observed(N);
    if (!observed.all()) return FixStatus::kPoorGeometry;
    gain = observed.solve(Eigen::Matrix<double, 3, 4>(J.transpose() * weight.asDiagonal()));
    const Eigen::Vector3d change = gain * residual;
    pose.p_m += change.head<2>();
    pose.heading_rad = wrap_angle(pose.heading_rad + change.z());
    residual -= J * change;
    converged = change.cwiseAbs().maxCoeff() < 1e-10;
  }
  if (!converged) return FixStatus::kNotConverged;

  // Noise and calibration uncertainty, which several of the ranges share.
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = rotation(pose.heading_rad);
  range_errors_.clear();
  for (int i = 0; i < 4; ++i)
    range_errors_.add(Eigen::Vector4d::Unit(i), links_[static_cast<std::size_t>(i)].pair,
                      toward.row(i).transpose(), R);
  const Eigen::Matrix4d V = range_errors_.covariance(deployment_);
  const Eigen::Matrix4d Q = Eigen::Matrix4d::Identity() - J * gain;  // rank one: a single redundant range
  const double misclosure_variance = (Q * V * Q.transpose()).trace() + kRounding_m * kRounding_m;
  fix.cost = 0.5 * residual.cwiseAbs2().dot(weight);
  if (residual.squaredNorm() > options_.consensus_sigmas * options_.consensus_sigmas * misclosure_variance) {
    for (Rejection& r : fix.rejections)
      if (r == Rejection::kUsed) r = Rejection::kOutvoted;
    return FixStatus::kNoConsensus;
  }
  fix.covariance = gain * V * gain.transpose();
  return FixStatus::kOk;
}

}  // namespace octant
