// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/head_tail/head_tail.h"
#include "models/physics/plane.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/LU>

namespace octant {
namespace {

constexpr double kTurn = 2 * M_PI;

Eigen::Vector2d lever(const Deployment& d, ReceiverId receiver) {
  return d.receivers[receiver.index()].position_m.head<2>();
}

/// Receivers at head and tail of a vehicle: by name, or the first two.
std::array<ReceiverId, 2> ends_of(const Deployment& d, const SiteVehicle& vehicle) {
  std::array<ReceiverId, 2> named;
  for (std::size_t i = vehicle.first_receiver; i < vehicle.first_receiver + vehicle.receiver_count; ++i) {
    if (d.receivers[i].name == "head") named[0] = ReceiverId(i);
    if (d.receivers[i].name == "tail") named[1] = ReceiverId(i);
  }
  if (named[0].valid() && named[1].valid()) return named;
  if (vehicle.receiver_count != 2) return {};
  return {ReceiverId(vehicle.first_receiver), ReceiverId(vehicle.first_receiver + 1)};
}

bool apart(const Deployment& d, const std::array<ReceiverId, 2>& ends) {
  return ends[0].valid() && (lever(d, ends[0]) - lever(d, ends[1])).norm() > 1e-3;
}

}  // namespace

double head_orientation_from_y_rad(const Eigen::Vector2d& head_m, const Eigen::Vector2d& tail_m) {
  const Eigen::Vector2d vector =
      tail_m - head_m;  // step 1; atan2 replaces steps 2 and 4 (unit vector, arccos) at full precision
  const double dot = vector.y();            // step 3: with the y axis
  const double cross_product = vector.x();  // step 5: vector x y axis, along +z where the angle is clockwise
  const double theta = std::atan2(cross_product, dot);
  return theta < 0 ? theta + kTurn : theta;  // step 6: counter-clockwise angles from 360 degrees
}

double tail_orientation_from_y_rad(double head_orientation_rad) {
  const double theta = M_PI - head_orientation_rad;  // step 7
  return theta < 0 ? theta + kTurn : theta;
}

HeadTail::HeadTail(const Deployment& deployment, HeadTailOptions options)
    : Localizer(deployment),
      deployment_(deployment),
      options_(options),
      ranges_(deployment, options.ranges),
      propagation_(deployment),
      end_{End{{}, {}, {}, {}, TriangleSolver(kMaxStations, options.min_sine, options.gate_sigmas)},
           End{{}, {}, {}, {}, TriangleSolver(kMaxStations, options.min_sine, options.gate_sigmas)}} {
  for (const SiteVehicle& vehicle : deployment_.vehicles) {
    const Ends ends = ends_of(deployment_, vehicle);
    ends_.push_back(apart(deployment_, ends) ? ends : Ends{});
  }
  for (End& end : end_) {
    end.stations.reserve(kMaxStations);
    end.pairs.reserve(kMaxStations);
    end.by_slant.reserve(kMaxStations);
  }
}

/// Removes the farthest station if it is farther than a new one; the others keep their order.
bool HeadTail::make_room(End& end, double horizontal_m, std::span<const Arrival> arrivals, Fix& fix) const {
  const auto farthest = std::ranges::max_element(end.stations, {}, &StationRange::distance_m);
  if (farthest->distance_m <= horizontal_m) return false;
  const auto at = farthest - end.stations.begin();
  reject_pair(arrivals, end.pairs[static_cast<std::size_t>(at)], Rejection::kNotNeeded, fix.rejections);
  end.stations.erase(farthest);
  end.pairs.erase(end.pairs.begin() + at);
  end.by_slant.erase(end.by_slant.begin() + at);
  return true;
}

/// Collects the stations that an end receives, with slant distances reduced to horizontal ones by the known
/// heights.
void HeadTail::gather(std::size_t which, std::span<const Arrival> arrivals, std::span<const PairRange> pairs,
                      Fix& fix) {
  End& end = end_[which];
  end.stations.clear();
  end.pairs.clear();
  end.by_slant.clear();
  for (const PairRange& pair : pairs) {
    if (pair.receiver != end.receiver) continue;
    const Eigen::Vector3d& station = deployment_.beacons[pair.beacon.index()].position_m;
    const double rise_m = station.z() - deployment_.receivers[pair.receiver.index()].position_m.z();
    const double variance_m2 = pair.sigma_m * pair.sigma_m + calibration_variance_m2(pair, deployment_);
    const double noise_m = options_.gate_sigmas * std::sqrt(variance_m2);
    const double horizontal2 = (pair.range_m - rise_m) * (pair.range_m + rise_m);
    if (!(horizontal2 >
          noise_m * pair.range_m)) {  // right below a station its range does not determine the position
      const bool impossible = pair.range_m < std::abs(rise_m) - noise_m;
      reject_pair(arrivals, pair, impossible ? Rejection::kEarly : Rejection::kNotNeeded, fix.rejections);
      continue;
    }
    const double horizontal_m = std::sqrt(horizontal2), by_slant = pair.range_m / horizontal_m;
    if (end.stations.size() == kMaxStations && !make_room(end, horizontal_m, arrivals, fix)) {
      reject_pair(arrivals, pair, Rejection::kNotNeeded, fix.rejections);
      continue;
    }
    end.stations.push_back({station.head<2>(), horizontal_m, by_slant * std::sqrt(variance_m2)});
    end.pairs.push_back(pair);
    end.by_slant.push_back(by_slant);
  }
}

/// Rates two positions as head and tail, by the residuals of their stations and the known distance between
/// them.
HeadTail::Choice HeadTail::rate(const TrianglePoint& head, const TrianglePoint& tail) const {
  const Eigen::Vector2d q = head.p_m - tail.p_m;
  const double length_m =
      (lever(deployment_, end_[0].receiver) - lever(deployment_, end_[1].receiver)).norm();
  const Eigen::Vector2d e = q.norm() > 0 ? Eigen::Vector2d(q.normalized()) : Eigen::Vector2d::UnitX();
  const double variance_m2 = e.dot((head.information.inverse() + tail.information.inverse()) * e);
  return {&head, &tail, head.cost + tail.cost + (q.norm() - length_m) * (q.norm() - length_m) / variance_m2};
}

bool HeadTail::on_side(const Choice& choice) const {
  const auto fits = [this](const End& end, const TrianglePoint& place) {
    const Eigen::Vector2d first = end.stations.front().p_m, last = end.stations.back().p_m;
    return cross(last - first, place.p_m - first) * static_cast<double>(options_.side) > 0;
  };
  return fits(end_[0], *choice.head) && fits(end_[1], *choice.tail);
}

FixStatus HeadTail::choose(Choice& best) const {
  std::array<Choice, 4> choices;
  std::size_t count = 0, least = 0, tied = 0, on_this_side = 0, chosen = 0;
  for (const TrianglePoint& head : end_[0].solver.places())
    for (const TrianglePoint& tail : end_[1].solver.places()) choices[count++] = rate(head, tail);
  for (std::size_t i = 0; i < count; ++i)
    if (choices[i].cost < choices[least].cost) least = i;
  for (std::size_t i = 0; i < count; ++i) {
    if (choices[i].cost > choices[least].cost + options_.ambiguity_margin) continue;
    ++tied;
    if (options_.side == BaseLineSide::kAny || !on_side(choices[i])) continue;
    ++on_this_side;
    chosen = i;
  }
  if (tied > 1 && on_this_side != 1) return FixStatus::kAmbiguous;
  best = choices[tied > 1 ? chosen : least];
  const double off = best.cost - best.head->cost - best.tail->cost;
  return off > options_.gate_sigmas * options_.gate_sigmas ? FixStatus::kNoConsensus : FixStatus::kOk;
}

FixStatus HeadTail::set_pose(const Choice& choice, Fix& fix) {
  const Eigen::Vector2d head = choice.head->p_m, tail = choice.tail->p_m, q = head - tail;
  if (!(q.norm() > 1e-6)) return FixStatus::kPoorGeometry;
  const std::array<Eigen::Vector2d, 2> levers = {lever(deployment_, end_[0].receiver),
                                                 lever(deployment_, end_[1].receiver)};
  const Eigen::Vector2d axis = levers[0] - levers[1];
  // Section VI gives the direction from tail to head from the y axis. In the vehicle frame the head need not
  // lie on +x from the tail.
  const double towards_head = tail_orientation_from_y_rad(head_orientation_from_y_rad(head, tail)) + M_PI / 2;
  const double heading_rad = wrap_angle(towards_head - std::atan2(axis.y(), axis.x()));
  const Eigen::Rotation2Dd R(heading_rad);
  // Each end gives a position of the vehicle; weights are their information.
  const Eigen::Matrix2d covariance = (choice.head->information + choice.tail->information).inverse();
  const std::array<Eigen::Matrix2d, 2> share = {covariance * choice.head->information,
                                                covariance * choice.tail->information};
  const Eigen::Vector2d from_head = head - R * levers[0], from_tail = tail - R * levers[1];
  const Eigen::Vector2d place = from_head + share[1] * (from_tail - from_head);
  fix.T_map_vehicle = Pose::planar(place.x(), place.y(), heading_rad);

  // Uses the known distance between the ends, because the measured one is noisy.
  const Eigen::RowVector2d heading_by_head = left_of(q.normalized()).transpose() / axis.norm();
  const Eigen::Vector2d by_heading = -(share[0] * left_of(R * levers[0]) + share[1] * left_of(R * levers[1]));
  propagation_.clear();
  for (std::size_t e = 0; e < 2; ++e) {
    const TrianglePoint& point = e == 0 ? *choice.head : *choice.tail;
    for (std::size_t k = 0; k < end_[e].pairs.size(); ++k) {
      const Eigen::Vector2d by_range = end_[e].by_slant[k] * point.gain[k];
      const double heading = (e == 0 ? 1.0 : -1.0) * heading_by_head.dot(by_range);
      Eigen::Vector3d gain;
      gain << share[e] * by_range + by_heading * heading, heading;
      propagation_.add(gain, end_[e].pairs[k], fix.T_map_vehicle, deployment_);
    }
  }
  fix.covariance = propagation_.covariance(deployment_);
  fix.cost = 0.5 * choice.cost;
  const bool finite = fix.covariance.allFinite() && place.allFinite();
  if (!finite || fix.covariance.topLeftCorner<2, 2>().trace() > options_.max_sigma_m * options_.max_sigma_m ||
      fix.covariance(2, 2) > options_.max_heading_sigma_rad * options_.max_heading_sigma_rad)
    return FixStatus::kPoorGeometry;
  return FixStatus::kOk;
}

FixStatus HeadTail::fix_pose(std::span<const Arrival> arrivals, Fix& fix) {
  const std::span<const PairRange> pairs = ranges_.collect(arrivals, deployment_, fix.rejections);
  if (pairs.empty() || !fix.vehicle.valid() || fix.vehicle.index() >= ends_.size() ||
      !ends_[fix.vehicle.index()][0].valid())
    return FixStatus::kTooFewArrivals;
  const Ends& ends = ends_[fix.vehicle.index()];
  for (const PairRange& pair : pairs)
    if (pair.receiver != ends[0] && pair.receiver != ends[1])
      reject_pair(arrivals, pair, Rejection::kNotNeeded, fix.rejections);
  TriangleStatus worst = TriangleStatus::kOk;
  for (std::size_t e = 0; e < 2; ++e) {
    end_[e].receiver = ends[e];
    gather(e, arrivals, pairs, fix);
    if (const TriangleStatus status = end_[e].solver.solve(end_[e].stations); worst == TriangleStatus::kOk)
      worst = status;
  }
  if (worst == TriangleStatus::kTooFew) return FixStatus::kTooFewArrivals;
  if (worst == TriangleStatus::kFlat) return FixStatus::kPoorGeometry;
  if (worst == TriangleStatus::kContradiction) return FixStatus::kNoConsensus;
  Choice choice;
  if (const FixStatus status = choose(choice); status != FixStatus::kOk) return status;
  for (std::size_t e = 0; e < 2; ++e) {
    const TrianglePoint& point = e == 0 ? *choice.head : *choice.tail;
    for (std::size_t k = 0; k < point.gain.size(); ++k) {
      if (!point.gain[k].isZero(0.0)) continue;
      const bool outvoted = static_cast<int>(k) == point.left_out;
      reject_pair(arrivals, end_[e].pairs[k], outvoted ? Rejection::kOutvoted : Rejection::kNotNeeded,
                  fix.rejections);
    }
  }
  return set_pose(choice, fix);
}

void HeadTail::locate_known(const Observations& observations, Fix& fix) noexcept {
  begin_fix(observations.arrivals, fix);
  end_fix(fix_pose(observations.arrivals, fix), fix);
}

Result<void> head_tail_fits(const Deployment& deployment) {
  const MisfitOf lacks("head_tail");
  if (auto plane = lacks.in_the_plane(deployment); !plane) return plane;
  const std::size_t usable = usable_beacons(deployment);
  if (usable < 2) return lacks(std::to_string(usable).append(" usable base stations"), "two or more");
  const bool any = std::ranges::any_of(deployment.vehicles, [&](const SiteVehicle& vehicle) {
    return apart(deployment, ends_of(deployment, vehicle));
  });
  if (!any) {
    return lacks("no vehicle has a head and a tail",
                 "one with two receivers at different places (the first is the head), or receivers named "
                 "head and tail");
  }
  return {};
}

}  // namespace octant
