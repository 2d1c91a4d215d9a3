// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/receptions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "models/localizers/least_squares/epoch_fix.h"

namespace octant::calib {
namespace {

/// Largest number of distances in a log; the arrivals of longer recordings are thinned.
constexpr std::size_t kMostDistances = 4'000'000;

/// Selects one of `stride` arrivals without a period that a firing schedule could share.
bool is_selected(std::size_t index, std::size_t stride) {
  constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
  return ((index * kGolden) >> 32U) % stride == 0;
}

/// Returns true if a point is within the field of view of a receiver.
bool is_in_view(const Deployment& d, VehicleId vehicle, const Pose& T_map_vehicle,
                const Eigen::Vector3d& p_map_m) {
  const Eigen::Vector3d to = T_map_vehicle.rotation.conjugate() * (p_map_m - T_map_vehicle.translation_m);
  return std::ranges::any_of(d.receivers, [&](const DeploymentReceiver& r) {
    if (r.vehicle != vehicle) return false;
    if (!r.axis) return true;
    const Eigen::Vector2d axis = r.axis->head<2>(), flat = (to - r.position_m).head<2>();
    return axis.dot(flat) >= r.hearing_cosine.value_or(kHearingCosine) * axis.norm() * flat.norm();
  });
}

/// Number of arrivals that are received or lost together: those of one owner at a stop, or in a row while
/// the vehicle drives.
template <class Owner>
class ClusterSize {
 public:
  explicit ClusterSize(Owner owner) : owner_(std::move(owner)) {}
  void add(const Trajectory& t, const ArrivalObservation& a) {
    const std::size_t owner = owner_(a);
    if (!t.moving && a.node != node_) {
      node_ = a.node;
      in_node_.clear();
    }
    if (t.moving) {
      clusters_ += owner != last_;
    } else if (std::ranges::find(in_node_, owner) == in_node_.end()) {
      in_node_.push_back(owner);
      ++clusters_;
    }
    last_ = owner;
    ++arrivals_;
  }
  [[nodiscard]] double mean() const {
    return static_cast<double>(arrivals_) / static_cast<double>(std::max<std::size_t>(clusters_, 1));
  }

 private:
  Owner owner_;
  std::size_t node_ = SIZE_MAX, last_ = SIZE_MAX, clusters_ = 0, arrivals_ = 0;
  std::vector<std::size_t> in_node_;
};

/// Tests the owners of arrivals.
/// @param of_vehicle  returns true if a trajectory counts
/// @param distances  (trajectory, pose): distances of all owners
template <class Owner, class OfVehicle, class Distances>
std::vector<Reception> receptions(std::size_t count, double reach_m,
                                  const std::vector<Trajectory>& trajectories, Owner owner,
                                  OfVehicle&& of_vehicle, Distances&& distances) {
  std::size_t all = 0;
  for (const Trajectory& t : trajectories) all += of_vehicle(t) ? t.arrivals.size() : 0;
  const std::size_t stride = all * count / kMostDistances + 1;
  ReceptionLog log(count, reach_m);
  ClusterSize<Owner> cluster(owner);
  std::vector<double> distance_m;
  std::size_t index = 0;
  for (const Trajectory& t : trajectories) {
    if (!of_vehicle(t)) continue;
    std::size_t node = SIZE_MAX;
    for (const ArrivalObservation& a : t.arrivals) {
      if (!t.nodes[a.node].placed || owner(a) >= count) continue;
      cluster.add(t, a);
      if (!is_selected(index++, stride)) continue;
      if (a.node != node) distance_m = distances(t, t.nodes[node = a.node].T_map_vehicle);
      log.add(a.time_s, owner(a), distance_m);
    }
  }
  const auto factor = static_cast<double>(stride);
  std::vector<Reception> found = log.judge(cluster.mean() / factor);
  for (Reception& r : found)
    for (double* number : {&r.received, &r.expected, &r.silence.received, &r.silence.expected})
      *number *= factor;
  return found;
}

}  // namespace

std::vector<Reception> receptions_of_beacons(const Deployment& before,
                                             const std::vector<Trajectory>& trajectories) {
  const std::size_t count = before.beacons.size();
  return receptions(
      count, before.validity_reach_m.value_or(INFINITY), trajectories,
      [](const ArrivalObservation& a) { return a.beacon.index(); }, [](const Trajectory&) { return true; },
      [&](const Trajectory& t, const Pose& T_map_vehicle) {
        std::vector<double> distance_m;
        for (const DeploymentBeacon& b : before.beacons)
          distance_m.push_back(b.status != BeaconStatus::kUndetermined &&
                                       is_in_view(before, t.vehicle, T_map_vehicle, b.position_m)
                                   ? (b.position_m - T_map_vehicle.translation_m).norm()
                                   : INFINITY);
        return distance_m;
      });
}

std::vector<Reception> receptions_by_receivers(const Deployment& before,
                                               const std::vector<Trajectory>& trajectories) {
  std::vector<Reception> all(before.receivers.size());
  for (std::size_t v = 0; v < before.vehicles.size(); ++v) {
    std::vector<std::size_t> own;
    for (std::size_t r = 0; r < before.receivers.size(); ++r)
      if (before.receivers[r].vehicle.index() == v) own.push_back(r);
    const auto found = receptions(
        own.size(), INFINITY, trajectories,
        [&](const ArrivalObservation& a) {
          return static_cast<std::size_t>(std::ranges::find(own, a.receiver.index()) - own.begin());
        },
        [v](const Trajectory& t) { return t.vehicle.index() == v; },
        [&](const Trajectory&, const Pose&) { return std::vector<double>(own.size(), 0.0); });
    for (std::size_t k = 0; k < own.size(); ++k) all[own[k]] = found[k];
  }
  return all;
}

}  // namespace octant::calib
