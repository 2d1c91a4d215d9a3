// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Least squares adjustment of OneBeacon's beacons, and choice of the beacons and sides to use.
#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "models/changes/chi_square.h"
#include "models/localizers/rail/one_beacon.h"
#include "models/physics/plane.h"

namespace octant {
namespace {

constexpr double kDistinct_m = 1e-3;
constexpr double kSlack_m = 0.1;  // tolerance beyond the distance that the vehicle can have moved

}  // namespace

/// Residual of a range at a pose, and its derivatives by the pose.
double OneBeacon::row(const View& seen, std::size_t end, const Eigen::Vector3d& pose,
                      Eigen::Vector3d& by_pose) const {
  const PairRange& pair = seen.pair[end];
  const Sight sight =
      sight_of(Pose::planar(pose.x(), pose.y(), pose.z()), pair.beacon, pair.receiver, deployment_);
  by_pose = sight.by_pose;
  return pair.range_m - sight.distance_m;
}

/// Least squares adjustment of the ranges, and of the heading if it is known. With one beacon there are two
/// ranges for two unknowns, so the pose does not change.
OneBeacon::Attempt OneBeacon::adjust(Eigen::Vector3d pose, int left_out) const {
  Attempt out;
  const std::optional<double> known_rad = known_heading_rad();
  const double weight = 1 / (options_.heading_sigma_rad * options_.heading_sigma_rad);
  for (int i = 0; i < 20; ++i) {
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero(), by_pose;
    out.cost = 0.0;
    if (known_rad) {
      const double off = wrap_angle(*known_rad - pose.z());
      N(2, 2) += weight;
      g.z() += weight * off;
      out.cost += weight * off * off;
    }
    for (std::size_t k = 0; k < views_.size(); ++k) {
      if (static_cast<int>(k) == left_out) continue;
      for (std::size_t end = 0; end < 2; ++end) {
        const double sigma_m = views_[k].pair[end].sigma_m, residual_m = row(views_[k], end, pose, by_pose);
        N += by_pose * by_pose.transpose() / (sigma_m * sigma_m);
        g += by_pose * residual_m / (sigma_m * sigma_m);
        out.cost += residual_m * residual_m / (sigma_m * sigma_m);
      }
    }
    bool invertible = false;
    N.computeInverseWithCheck(out.covariance, invertible, 0.0);
    const Eigen::Vector3d step = out.covariance * g;
    if (!invertible || !step.allFinite()) return out;
    out.pose = pose;
    out.ok = step.dot(g) < 1e-6;  // in squared sigmas
    if (step.dot(g) < 1e-20) break;
    pose += step;
  }
  out.pose.z() = wrap_angle(out.pose.z());
  return out;
}

/// Protection level from the fixes without each of the beacons; 0 if too few remain. An externally known
/// heading is assumed to be correct.
double OneBeacon::protection_level(const Attempt& attempt, int left_out, const Eigen::Matrix3d& covariance) {
  sums_.clear();
  if (const std::optional<double> known_rad = known_heading_rad())
    sums_.add(Eigen::RowVector3d(0, 0, 1 / options_.heading_sigma_rad),
              wrap_angle(*known_rad - attempt.pose.z()) / options_.heading_sigma_rad);
  Eigen::Vector3d by_pose;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    if (static_cast<int>(k) == left_out) continue;
    for (std::size_t end = 0; end < 2; ++end) {
      const PairRange& pair = views_[k].pair[end];
      const double residual_m = row(views_[k], end, attempt.pose, by_pose);
      sums_.add(pair.beacon, Eigen::RowVector3d(by_pose.transpose() / pair.sigma_m),
                residual_m / pair.sigma_m,
                calibration_variance_m2(pair, deployment_) / (pair.sigma_m * pair.sigma_m));
    }
  }
  return sums_.level_m(horizontal_variance(covariance));
}

/// Returns true if the vehicle can have moved there since the last fix, or if beacons that agree confirm the
/// position.
bool OneBeacon::in_reach(const Fix& fix, int left_out, const Attempt& attempt) const {
  const Last& last = last_[fix.vehicle.index()];
  const std::size_t beacons = views_.size() - (left_out >= 0 ? 1 : 0);
  const bool agree = beacons > (known_heading_rad() ? 1u : 2u) && attempt.cost <= gate(left_out);
  if (!last.known || agree) return true;
  const auto& motion = deployment_.vehicles[fix.vehicle.index()].motion;
  const double speed_mps = motion ? motion->speed_mps : options_.max_speed_mps;
  const double sigma_m = std::sqrt(attempt.covariance.topLeftCorner<2, 2>().trace());
  const double reach_m =
      kSlack_m + options_.gate_sigmas * sigma_m + speed_mps * std::abs(fix.time_s - last.time_s);
  return (attempt.pose.head<2>() - last.p_m).norm() <= reach_m;
}

/// Chooses the sides that explain the ranges best, among those within reach.
FixStatus OneBeacon::choose(const Fix& fix, int left_out, Attempt& best) const {
  if (options_.facing != Facing::kEither) {
    best = adjust(start(options_.facing == Facing::kLeft ? 0u : ~0u, left_out), left_out);
    if (!best.ok) return FixStatus::kPoorGeometry;
    return in_reach(fix, left_out, best) ? FixStatus::kOk : FixStatus::kNoConsensus;
  }
  std::array<Attempt, 1u << kMaxEither> attempts;
  std::size_t least = 0, count = 0;
  bool any = false;
  for (unsigned sides = 0; sides < (1u << views_.size()); ++sides) {
    attempts[count] = adjust(start(sides, left_out), left_out);
    any = any || attempts[count].ok;
    if (!attempts[count].ok || !in_reach(fix, left_out, attempts[count])) continue;
    if (attempts[count].cost < attempts[least].cost) least = count;
    ++count;
  }
  if (count == 0) return any ? FixStatus::kNoConsensus : FixStatus::kPoorGeometry;
  best = attempts[least];
  for (std::size_t i = 0; i < count; ++i) {
    if (attempts[i].cost > best.cost + options_.ambiguity_margin) continue;
    const double sigma_m = std::sqrt(attempts[i].covariance.topLeftCorner<2, 2>().trace());
    if ((attempts[i].pose - best.pose).head<2>().norm() > options_.gate_sigmas * sigma_m + kDistinct_m)
      return FixStatus::kAmbiguous;
  }
  return FixStatus::kOk;
}

/// One of three or more beacons may be an echo. With two beacons, the last position may decide which one.
FixStatus OneBeacon::without_one(const Fix& fix, int& left_out, Attempt& best) const {
  const std::size_t least_beacons = known_heading_rad() ? 1 : 2;
  if (views_.size() <= least_beacons || (views_.size() < 3 && !last_[fix.vehicle.index()].known))
    return FixStatus::kNoConsensus;
  int agreeing = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < static_cast<int>(views_.size()); ++k) {
    Attempt without;
    if (choose(fix, k, without) != FixStatus::kOk || without.cost > gate(k)) continue;
    ++agreeing;
    if (without.cost >= least) continue;
    least = without.cost;
    left_out = k;
    best = without;
  }
  if (agreeing == 0 || (views_.size() < 3 && agreeing > 1)) return FixStatus::kNoConsensus;
  return FixStatus::kOk;
}

/// Upper bound of the cost, including the calibration uncertainty.
double OneBeacon::gate(int left_out) const {
  const int beacons = static_cast<int>(views_.size()) - (left_out >= 0 ? 1 : 0);
  const int dof = 2 * beacons - (known_heading_rad() ? 2 : 3);
  double factor = 1.0;
  for (const View& seen : views_)
    for (const PairRange& pair : seen.pair)
      factor =
          std::max(factor, 1 + calibration_variance_m2(pair, deployment_) / (pair.sigma_m * pair.sigma_m));
  return factor * chi2_gate(std::max(dof, 1), options_.gate_sigmas);
}

/// A single beacon determines the distance far better than the direction. The uncertainty region is an arc
/// around the beacon: a lateral error t displaces the robot by t^2 / 2L along the line of sight as well. Adds
/// the second moment of that for normal t.
void OneBeacon::add_bend(const Eigen::Vector2d& p_map_m, Eigen::Matrix3d& covariance) const {
  const Eigen::Vector2d off =
      p_map_m - deployment_.beacons[views_[0].pair[0].beacon.index()].position_m.head<2>();
  const double L2 = off.squaredNorm();
  if (!(L2 > 0)) return;
  const Eigen::Vector2d along = off / std::sqrt(L2), across = left_of(along);
  const double variance_m2 = across.dot(covariance.topLeftCorner<2, 2>() * across);
  covariance.topLeftCorner<2, 2>() += 0.75 * variance_m2 * variance_m2 / L2 * along * along.transpose();
}

}  // namespace octant
