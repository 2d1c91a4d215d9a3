// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/rail/one_beacon.h"
#include "models/physics/plane.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Geometry>

namespace octant {
namespace {

constexpr double kMinBaseline_m = 1e-3;
constexpr double kMinHeadingSigma_rad = 1e-9;  // lower bound of a heading's sigma, which keeps weights finite

/// The two receivers of a vehicle that are farthest apart, in their order.
std::array<ReceiverId, 2> widest_pair(const Deployment& d, const SiteVehicle& vehicle) {
  std::array<ReceiverId, 2> widest;
  double most_m = kMinBaseline_m;
  const std::size_t end = vehicle.first_receiver + vehicle.receiver_count;
  for (std::size_t i = vehicle.first_receiver; i < end; ++i) {
    for (std::size_t j = i + 1; j < end; ++j) {
      const double base_m = (d.receivers[i].position_m - d.receivers[j].position_m).head<2>().norm();
      // A later pair must be wider by more than rounding, so that regular arrays give the same pair on every
      // machine.
      if (base_m <= most_m * (1 + 1e-9)) continue;
      most_m = base_m;
      widest = {ReceiverId(i), ReceiverId(j)};
    }
  }
  return widest;
}

std::optional<double> straight_heading_rad(const SiteVehicle& vehicle) {
  if (!vehicle.rail || vehicle.rail->shape != Rail::Shape::kStraight) return std::nullopt;
  const Eigen::Vector2d along = vehicle.rail->to_m - vehicle.rail->from_m;
  return std::atan2(along.y(), along.x());
}

}  // namespace

std::optional<Eigen::Vector2d> beacon_in_robot_frame(double a, double L1, double L2, bool left) {
  if (!(a > 0 && L1 > 0 && L2 > 0)) return std::nullopt;
  // eq. 4: the difference of both equations gives x_br; y_br^2 = L1^2 - (x_br + a)^2 in factors, which avoid
  // cancellation.
  const double x = (L1 - L2) * (L1 + L2) / (4 * a);
  const double y2 =
      (L1 + L2 - 2 * a) * (L1 + L2 + 2 * a) * (2 * a - (L1 - L2)) * (2 * a + (L1 - L2)) / (16 * a * a);
  if (!(y2 >= 0)) return std::nullopt;
  return Eigen::Vector2d(x, left ? std::sqrt(y2) : -std::sqrt(y2));
}

Eigen::Vector2d robot_in_map(const Eigen::Vector2d& beacon_robot_m, const Eigen::Vector2d& beacon_map_m,
                             double heading_rad) {
  // eq. 5 for the robot's origin, X_r = 0, in a frame at the beacon with the axes of the map. The shift,
  // which the paper prints as (X_r, Y_r) again, is the robot as seen from the beacon: minus the rotated
  // position of the beacon in the robot frame.
  const Eigen::Vector2d robot_beacon_m = -(Eigen::Rotation2Dd(heading_rad) * beacon_robot_m);
  return robot_beacon_m + beacon_map_m;  // eq. 6
}

OneBeacon::OneBeacon(const Deployment& deployment, OneBeaconOptions options)
    : Localizer(deployment),
      deployment_(deployment),
      options_(options),
      last_(deployment.vehicles.size()),
      ranges_(deployment, options.ranges),
      propagation_(deployment),
      sums_(3, deployment.beacons.size()),
      heading_rad_(options.heading_rad) {
  options_.heading_sigma_rad = std::max(options_.heading_sigma_rad, kMinHeadingSigma_rad);
  for (const SiteVehicle& vehicle : deployment_.vehicles)
    receivers_.push_back({widest_pair(deployment_, vehicle), straight_heading_rad(vehicle)});
  views_.reserve(deployment_.beacons.size());
}

void OneBeacon::set_heading(double heading_rad, double sigma_rad) noexcept {
  heading_rad_ = heading_rad;
  options_.heading_sigma_rad = std::max(sigma_rad, kMinHeadingSigma_rad);
}

/// Both positions of a beacon in the vehicle frame. No value if the circles do not meet; `flat` if they touch
/// within noise.
std::optional<OneBeacon::View> OneBeacon::view(const PairRange& first, const PairRange& second,
                                               bool& flat) const {
  View out{.pair = {first, second}, .place = {}, .distance_m = 0.5 * (first.range_m + second.range_m)};
  const Eigen::Vector3d& beacon = deployment_.beacons[first.beacon.index()].position_m;
  std::array<double, 2> L{};
  double noise_m = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    const double rise_m = beacon.z() - deployment_.receivers[now_.id[i].index()].position_m.z();
    const double range_m = out.pair[i].range_m;
    const double L2 = (range_m - rise_m) * (range_m + rise_m);
    L[i] = L2 > 0 ? std::sqrt(L2) : 0.0;
    const double sigma_m =
        std::hypot(out.pair[i].sigma_m, std::sqrt(calibration_variance_m2(out.pair[i], deployment_)));
    noise_m = std::hypot(noise_m, options_.gate_sigmas * sigma_m * range_m / std::max(L[i], sigma_m));
  }
  const Eigen::Vector2d r1 = deployment_.receivers[now_.id[0].index()].position_m.head<2>();
  const Eigen::Vector2d r2 = deployment_.receivers[now_.id[1].index()].position_m.head<2>();
  const double a = 0.5 * (r2 - r1).norm();
  for (std::size_t side = 0; side < 2; ++side) {
    const auto place = beacon_in_robot_frame(a, L[0], L[1], side == 0);
    if (!place) {
      flat = std::abs(L[0] - L[1]) < 2 * a + noise_m && L[0] + L[1] > 2 * a - noise_m;
      return std::nullopt;
    }
    const Eigen::Vector2d along = (r2 - r1) / (2 * a);
    out.place[side] = 0.5 * (r1 + r2) + place->x() * along + place->y() * left_of(along);
  }
  return out;
}

/// Beacons that both receivers observe.
FixStatus OneBeacon::view_beacons(std::span<const Arrival> arrivals, std::span<const PairRange> pairs,
                                  Fix& fix) {
  views_.clear();
  bool any_flat = false, any_open = false;
  for (const PairRange& first : pairs) {
    if (first.receiver != now_.id[0]) {
      const bool has_first = std::ranges::any_of(
          pairs, [&](const PairRange& p) { return p.beacon == first.beacon && p.receiver == now_.id[0]; });
      if (first.receiver != now_.id[1] || !has_first)
        reject_pair(arrivals, first, Rejection::kNotNeeded, fix.rejections);
      continue;
    }
    const auto second = std::ranges::find_if(
        pairs, [&](const PairRange& p) { return p.beacon == first.beacon && p.receiver == now_.id[1]; });
    if (second == pairs.end()) {
      reject_pair(arrivals, first, Rejection::kNotNeeded, fix.rejections);
      continue;
    }
    bool flat = false;
    if (const std::optional<View> seen = view(first, *second, flat)) {
      views_.push_back(*seen);
      continue;
    }
    (flat ? any_flat : any_open) = true;
    reject_pair(arrivals, first, flat ? Rejection::kNotNeeded : Rejection::kOutvoted, fix.rejections);
    reject_pair(arrivals, *second, flat ? Rejection::kNotNeeded : Rejection::kOutvoted, fix.rejections);
  }
  if (options_.facing == Facing::kEither && views_.size() > kMaxEither) {  // keeps the nearest ones
    std::ranges::sort(views_, {}, &View::distance_m);
    for (std::size_t i = kMaxEither; i < views_.size(); ++i)
      for (const PairRange& pair : views_[i].pair)
        reject_pair(arrivals, pair, Rejection::kNotNeeded, fix.rejections);
    views_.resize(kMaxEither);
  }
  if (!views_.empty()) return FixStatus::kOk;
  if (any_open) return FixStatus::kNoConsensus;
  return any_flat ? FixStatus::kPoorGeometry : FixStatus::kTooFewArrivals;
}

/// Pose from eq. 4-6. The heading is the known one, or the least-squares rotation from the beacons' positions
/// in the vehicle frame to those in the map. The position is the mean over the beacons.
Eigen::Vector3d OneBeacon::start(unsigned sides, int left_out) const {
  Eigen::Vector2d mean_robot = Eigen::Vector2d::Zero(), mean_map = Eigen::Vector2d::Zero();
  const auto each = [&](const auto& visit) {
    for (std::size_t k = 0; k < views_.size(); ++k) {
      if (static_cast<int>(k) == left_out) continue;
      visit(views_[k].place[(sides >> k) & 1u],
            deployment_.beacons[views_[k].pair[0].beacon.index()].position_m.head<2>());
    }
  };
  const double count = static_cast<double>(views_.size()) - (left_out >= 0 ? 1 : 0);
  each([&](const Eigen::Vector2d& robot, const Eigen::Vector2d& map) {
    mean_robot += robot / count;
    mean_map += map / count;
  });
  double dot = 0.0, cross = 0.0;
  each([&](const Eigen::Vector2d& robot, const Eigen::Vector2d& map) {
    const Eigen::Vector2d r = robot - mean_robot, m = map - mean_map;
    dot += r.dot(m);
    cross += left_of(r).dot(m);
  });
  const double heading_rad = known_heading_rad().value_or(std::atan2(cross, dot));
  const Eigen::Vector2d p = robot_in_map(mean_robot, mean_map, heading_rad);
  return {p.x(), p.y(), heading_rad};
}

FixStatus OneBeacon::finish(const Attempt& attempt, int left_out, std::span<const Arrival> arrivals,
                            Fix& fix) {
  fix.T_map_vehicle = Pose::planar(attempt.pose.x(), attempt.pose.y(), attempt.pose.z());
  propagation_.clear();
  Eigen::Vector3d by_pose;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    for (std::size_t end = 0; end < 2; ++end) {
      const PairRange& pair = views_[k].pair[end];
      if (static_cast<int>(k) == left_out) {
        reject_pair(arrivals, pair, Rejection::kOutvoted, fix.rejections);
        continue;
      }
      static_cast<void>(row(views_[k], end, attempt.pose, by_pose));
      propagation_.add(attempt.covariance * by_pose / (pair.sigma_m * pair.sigma_m), pair, fix.T_map_vehicle,
                       deployment_);
    }
  }
  Eigen::Matrix3d covariance = propagation_.covariance(deployment_);
  if (known_heading_rad()) {
    const Eigen::Vector3d by_heading =
        attempt.covariance.col(2) / options_.heading_sigma_rad;  // gain times sigma
    covariance += by_heading * by_heading.transpose();
  }
  if (views_.size() == 1) add_bend(attempt.pose.head<2>(), covariance);
  fix.covariance = covariance;
  fix.protection_level_m = protection_level(attempt, left_out, covariance);
  fix.cost = 0.5 * attempt.cost;
  const bool sharp =
      covariance.allFinite() && covariance.diagonal().minCoeff() > 0 &&
      covariance.topLeftCorner<2, 2>().trace() <= options_.max_sigma_m * options_.max_sigma_m &&
      covariance(2, 2) <= options_.max_heading_sigma_rad * options_.max_heading_sigma_rad;
  return sharp ? FixStatus::kOk : FixStatus::kPoorGeometry;
}

FixStatus OneBeacon::fix_pose(std::span<const Arrival> arrivals, Fix& fix) {
  const std::span<const PairRange> pairs = ranges_.collect(arrivals, deployment_, fix.rejections);
  if (!fix.vehicle.valid() || fix.vehicle.index() >= receivers_.size()) return FixStatus::kTooFewArrivals;
  now_ = receivers_[fix.vehicle.index()];
  if (!now_.id[0].valid()) return FixStatus::kTooFewArrivals;
  if (const FixStatus status = view_beacons(arrivals, pairs, fix); status != FixStatus::kOk) return status;
  if (views_.size() < 2 && !known_heading_rad()) return FixStatus::kTooFewArrivals;
  Attempt best;
  int left_out = -1;
  FixStatus status = choose(fix, left_out, best);
  if (status == FixStatus::kNoConsensus || (status == FixStatus::kOk && best.cost > gate(left_out)))
    status = without_one(fix, left_out, best);
  if (status != FixStatus::kOk) return status;
  status = finish(best, left_out, arrivals, fix);
  if (status == FixStatus::kOk) last_[fix.vehicle.index()] = {true, fix.time_s, best.pose.head<2>()};
  return status;
}

void OneBeacon::locate_known(const Observations& observations, Fix& fix) noexcept {
  begin_fix(observations.arrivals, fix);
  end_fix(fix_pose(observations.arrivals, fix), fix);
}

void OneBeacon::forget() noexcept { std::ranges::fill(last_, Last{}); }

Result<void> one_beacon_fits(const Deployment& deployment, const OneBeaconOptions& options) {
  const MisfitOf lacks("one_beacon");
  if (auto plane = lacks.in_the_plane(deployment); !plane) return plane;
  const std::size_t usable = usable_beacons(deployment);
  if (usable < 1) return lacks("no usable beacon", "one or more");
  bool any = false, heading = options.heading_rad.has_value();
  for (const SiteVehicle& vehicle : deployment.vehicles) {
    if (!widest_pair(deployment, vehicle)[0].valid()) continue;
    any = true;
    heading = heading || straight_heading_rad(vehicle).has_value();
  }
  if (!any) return lacks("no vehicle has two receivers at different places", "one");
  if (usable < 2 && !heading) {
    return lacks("one beacon does not determine the heading",
                 "the heading, a straight rail of the vehicle, or a second beacon");
  }
  return {};
}

}  // namespace octant
