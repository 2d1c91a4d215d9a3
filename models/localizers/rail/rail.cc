// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/rail/rail.h"
#include "models/physics/plane.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace octant {
namespace {

constexpr double kRailSlack_m = 0.1;  // tolerance beyond the distance that the vehicle can have moved
constexpr double kDistinct = 5.0;
constexpr double kDistinctOnRail_m = 1e-3;

bool has_length(const Rail& rail) {
  return rail.shape == Rail::Shape::kStraight ? (rail.to_m - rail.from_m).norm() > 1e-3
                                              : rail.radius_m > 1e-3;
}

bool runs_on_rail(const SiteVehicle& vehicle) {
  return vehicle.rail && has_length(*vehicle.rail) && vehicle.receiver_count > 0;
}

}  // namespace

RailLocalizer::RailLocalizer(const Deployment& deployment, RailOptions options)
    : Localizer(deployment),
      deployment_(deployment),
      options_(options),
      ranges_(deployment, options.ranges),
      propagation_(deployment),
      sums_(3, deployment.beacons.size()),
      last_(deployment.vehicles.size()) {
  places_.reserve(2 * deployment.beacons.size() * deployment.receivers.size());
}

RailLocalizer::Row RailLocalizer::row(const PairRange& pair, const RailPoint& at) const {
  const Sight sight = sight_of(at.T_map_vehicle, pair.beacon, pair.receiver, deployment_);
  Row out;
  out.off_m = pair.range_m - sight.distance_m;
  out.by_s = sight.by_pose.dot(at.by_s);
  out.sigma_m = std::sqrt(pair.sigma_m * pair.sigma_m + calibration_variance_m2(pair, deployment_) +
                          options_.rail_sigma_m * options_.rail_sigma_m);
  return out;
}

/// Gauss-Newton along the rail on the ranges that agree; false if they do not determine s.
bool RailLocalizer::polish(std::span<const PairRange> pairs, Place& place) const {
  for (int i = 0; i < 12; ++i) {
    const RailPoint at = rail_point(*rail_, place.s_m);
    double information = 0.0, gradient = 0.0;
    for (const PairRange& pair : pairs) {
      const Row r = row(pair, at);
      // In the first iterations a position is only as accurate as the range it was computed from.
      const double slack_m = i < 3 ? r.by_s * place.sigma_m : 0.0;
      if (std::abs(r.off_m) > options_.gate_sigmas * std::hypot(r.sigma_m, slack_m)) continue;
      information += r.by_s * r.by_s / (r.sigma_m * r.sigma_m);
      gradient += r.by_s * r.off_m / (r.sigma_m * r.sigma_m);
    }
    if (!(information > 1 / (1e3 * 1e3 * options_.max_sigma_m * options_.max_sigma_m))) return false;
    const double step_m = gradient / information;
    place.sigma_m = 1 / std::sqrt(information);
    place.s_m = rail_wrapped_m(*rail_, place.s_m + step_m);
    if (i >= 3 && std::abs(step_m) < 1e-9 * place.sigma_m) break;
  }
  rate(pairs, place);
  return std::isfinite(place.s_m) && std::isfinite(place.cost);
}

/// Cost of a position: the squared residuals of the ranges that agree, and that of the gate for each other
/// range. A beacon behind an obstacle is late with all its ranges and counts once.
void RailLocalizer::rate(std::span<const PairRange> pairs, Place& place) const {
  const double gate = options_.gate_sigmas * options_.gate_sigmas;
  const RailPoint at = rail_point(*rail_, place.s_m);
  place.cost = 0.0;
  place.agreeing = place.beacons = 0;
  for (std::size_t i = 0; i < pairs.size();) {
    double sum = 0.0;
    int agreeing = 0;
    bool all_late = true;
    const BeaconId beacon = pairs[i].beacon;
    for (; i < pairs.size() && pairs[i].beacon == beacon; ++i) {
      const Row r = row(pairs[i], at);
      const double z = r.off_m / r.sigma_m;
      agreeing += std::abs(z) <= options_.gate_sigmas ? 1 : 0;
      all_late = all_late && z > 0;
      sum += std::min(z * z, gate) + (z < -options_.gate_sigmas ? options_.early_penalty : 0.0);
    }
    place.cost += all_late ? std::min(sum, gate) : sum;
    place.agreeing += agreeing;
    place.beacons += agreeing > 0 ? 1 : 0;
  }
}

/// Both positions of each range, adjusted.
void RailLocalizer::find_places(std::span<const PairRange> pairs) {
  places_.clear();
  for (const PairRange& pair : pairs) {
    const double sigma_m = std::hypot(pair.sigma_m, options_.rail_sigma_m,
                                      std::sqrt(calibration_variance_m2(pair, deployment_)));
    const RailPlaces found = rail_places(*rail_, deployment_.receivers[pair.receiver.index()].position_m,
                                         deployment_.beacons[pair.beacon.index()].position_m, pair.range_m,
                                         options_.gate_sigmas * sigma_m);
    for (int i = 0; i < found.count; ++i) {
      Place place{.s_m = found.s_m[static_cast<std::size_t>(i)]};
      const double by_s = row(pair, rail_point(*rail_, place.s_m)).by_s;
      place.sigma_m = sigma_m / std::max(std::abs(by_s), 1e-2);
      if (!polish(pairs, place) || place.agreeing == 0) continue;
      const bool straight = rail_->shape == Rail::Shape::kStraight;
      if (straight &&
          (place.s_m < -options_.end_slack_m || place.s_m > rail_length_m(*rail_) + options_.end_slack_m))
        continue;
      places_.push_back(place);
    }
  }
}

/// Returns true if the vehicle can have moved to a position since the last fix.
bool RailLocalizer::in_reach(const Fix& fix, const Place& place) const {
  const Last& last = last_[fix.vehicle.index()];
  if (!last.known) return true;
  const auto& motion = deployment_.vehicles[fix.vehicle.index()].motion;
  const double speed_mps = motion ? motion->speed_mps : options_.max_speed_mps;
  const double reach_m =
      kRailSlack_m + options_.gate_sigmas * place.sigma_m + speed_mps * std::abs(fix.time_s - last.time_s);
  return std::abs(rail_wrapped_m(*rail_, place.s_m - last.s_m)) <= reach_m;
}

FixStatus RailLocalizer::choose(std::span<const PairRange> pairs, const Fix& fix, Place& chosen) {
  std::erase_if(places_, [&](const Place& place) { return place.beacons < 2 && !in_reach(fix, place); });
  if (places_.empty()) return FixStatus::kNoConsensus;
  for (Place& place : places_)
    if (!in_reach(fix, place))
      place.cost += options_.gate_sigmas * options_.gate_sigmas;  // penalty of one outlier
  chosen = *std::ranges::min_element(places_, {}, &Place::cost);
  for (const Place& place : places_) {
    if (place.cost > chosen.cost + options_.ambiguity_margin) continue;
    const double apart_m = std::abs(rail_wrapped_m(*rail_, chosen.s_m - place.s_m));
    if (apart_m > kDistinct * std::hypot(chosen.sigma_m, place.sigma_m) + kDistinctOnRail_m)
      return FixStatus::kAmbiguous;
  }
  // Only the last position can confirm a single range.
  if (chosen.agreeing < 2 && !last_[fix.vehicle.index()].known)
    return pairs.size() < 2 ? FixStatus::kTooFewArrivals : FixStatus::kNoConsensus;
  return 2 * chosen.agreeing < static_cast<int>(pairs.size()) ? FixStatus::kNoConsensus : FixStatus::kOk;
}

/// Protection level from the positions without each of the beacons, on a rail with the given sigmas; 0 if it
/// depends on one beacon alone.
double RailLocalizer::protection_level(std::span<const PairRange> pairs, const RailPoint& at,
                                       const Eigen::Matrix3d& covariance) {
  const Eigen::Vector2d along = at.by_s.head<2>(), across = left_of(along) / options_.rail_sigma_m;
  sums_.clear();
  sums_.add(Eigen::RowVector3d(across.x(), across.y(), 0.0), 0.0);
  sums_.add(Eigen::RowVector3d(0.0, 0.0, 1 / options_.heading_sigma_rad), 0.0);
  for (const PairRange& pair : pairs) {
    const Row r = row(pair, at);
    if (std::abs(r.off_m) > options_.gate_sigmas * r.sigma_m) continue;
    const Eigen::Vector2d by = r.by_s / r.sigma_m * along;
    sums_.add(pair.beacon, Eigen::RowVector3d(by.x(), by.y(), 0.0), r.off_m / r.sigma_m, 0.0);
  }
  return sums_.level_m(horizontal_variance(covariance));
}

FixStatus RailLocalizer::finish(std::span<const PairRange> pairs, std::span<const Arrival> arrivals,
                                const Place& place, Fix& fix) {
  Last& last = last_[fix.vehicle.index()];
  const RailPoint at = rail_point(*rail_, place.s_m);
  fix.T_map_vehicle = at.T_map_vehicle;
  const Eigen::Vector2d along = at.by_s.head<2>();
  double information = 0.0, sway = 0.0, turn = 0.0;
  propagation_.clear();
  for (const bool add : {false, true}) {
    for (const PairRange& pair : pairs) {
      const Row r = row(pair, at);
      const double z = r.off_m / r.sigma_m, weight = r.by_s / (r.sigma_m * r.sigma_m);
      if (std::abs(z) > options_.gate_sigmas) {
        reject_pair(arrivals, pair, z > 0 ? Rejection::kLate : Rejection::kEarly, fix.rejections);
      } else if (add) {
        propagation_.add(at.by_s * weight / information, pair, at.T_map_vehicle, deployment_);
        fix.cost += 0.5 * z * z;
      } else {
        const Eigen::Vector3d by_pose =
            sight_of(at.T_map_vehicle, pair.beacon, pair.receiver, deployment_).by_pose;
        information += weight * r.by_s;
        sway += weight * by_pose.head<2>().dot(left_of(along));
        turn += weight * by_pose.z();
      }
    }
  }
  // Effect of lateral and angular play: the vehicle is off its rail, and its ranges are attributed to another
  // s.
  Eigen::Vector3d by_sway, by_turn;
  by_sway << left_of(along), 0.0;
  by_sway -= at.by_s * sway / information;
  by_turn << 0.0, 0.0, 1.0;
  by_turn -= at.by_s * turn / information;
  const Eigen::Matrix3d covariance =
      propagation_.covariance(deployment_) +
      options_.rail_sigma_m * options_.rail_sigma_m * by_sway * by_sway.transpose() +
      options_.heading_sigma_rad * options_.heading_sigma_rad * by_turn * by_turn.transpose();
  fix.covariance = covariance;
  fix.protection_level_m = protection_level(pairs, at, covariance);
  if (!covariance.allFinite() ||
      !(covariance.topLeftCorner<2, 2>().trace() < options_.max_sigma_m * options_.max_sigma_m))
    return FixStatus::kPoorGeometry;
  last = {true, fix.time_s, place.s_m};
  return FixStatus::kOk;
}

FixStatus RailLocalizer::fix_place(std::span<const Arrival> arrivals, Fix& fix) {
  const std::span<const PairRange> pairs = ranges_.collect(arrivals, deployment_, fix.rejections);
  if (pairs.empty() || !fix.vehicle.valid() || fix.vehicle.index() >= deployment_.vehicles.size())
    return FixStatus::kTooFewArrivals;
  const SiteVehicle& vehicle = deployment_.vehicles[fix.vehicle.index()];
  if (!runs_on_rail(vehicle)) return FixStatus::kTooFewArrivals;
  rail_ = &*vehicle.rail;
  find_places(pairs);
  if (places_.empty()) {
    // Either no position explains the ranges, or the vehicle is abreast of the only beacon, where the range
    // does not depend on the position.
    const bool any = std::ranges::any_of(pairs, [&](const PairRange& pair) {
      return rail_places(*rail_, deployment_.receivers[pair.receiver.index()].position_m,
                         deployment_.beacons[pair.beacon.index()].position_m, pair.range_m,
                         options_.gate_sigmas * pair.sigma_m)
                 .count == 1;
    });
    return any ? FixStatus::kPoorGeometry : FixStatus::kNoConsensus;
  }
  Place chosen;
  if (const FixStatus status = choose(pairs, fix, chosen); status != FixStatus::kOk) return status;
  return finish(pairs, arrivals, chosen, fix);
}

void RailLocalizer::locate_known(const Observations& observations, Fix& fix) noexcept {
  begin_fix(observations.arrivals, fix);
  end_fix(fix_place(observations.arrivals, fix), fix);
}

void RailLocalizer::forget() noexcept { std::ranges::fill(last_, Last{}); }

Result<void> rail_fits(const Deployment& deployment) {
  const MisfitOf lacks("rail");
  if (auto plane = lacks.in_the_plane(deployment); !plane) return plane;
  if (usable_beacons(deployment) == 0) return lacks("no usable beacon", "one or more");
  if (!std::ranges::any_of(deployment.vehicles, runs_on_rail)) {
    return lacks("no vehicle with receivers has a rail",
                 "rail: {from_m: [x, y], to_m: [x, y]} or {centre_m: [x, y], radius_m: R}");
  }
  return {};
}

}  // namespace octant
