// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/ray_speeds.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "models/trajectory/linearise.h"

namespace octant {
namespace {

constexpr double kNear_s = 1.0;  ///< a vehicle in water moves by a few metres in it: 1e-4 of its speed

/// The fix of an arrival: that of its epoch, else the nearest in time.
class FixOf {
 public:
  explicit FixOf(std::span<const Fix> fixes) {
    for (const Fix& fix : fixes) {
      if (!fix.ok()) continue;
      by_time_.push_back(&fix);
      if (fix.epoch != kNoEpoch) by_epoch_[fix.epoch].push_back(&fix);
    }
    std::ranges::sort(by_time_, {}, &Fix::time_s);
  }

  [[nodiscard]] const Fix* operator()(const Arrival& a) const {
    if (const auto at = by_epoch_.find(a.epoch); a.epoch != kNoEpoch && at != by_epoch_.end())
      for (const Fix* fix : at->second)
        if (fix->vehicle == a.vehicle) return fix;
    const auto after = std::ranges::lower_bound(by_time_, a.time_s, {}, &Fix::time_s);
    const Fix* nearest = nullptr;
    for (auto at = after == by_time_.begin() ? after : std::prev(after); at != by_time_.end() && at <= after;
         ++at) {
      const double apart_s = std::abs((*at)->time_s - a.time_s);
      if ((*at)->vehicle != a.vehicle || apart_s > kNear_s) continue;
      if (nearest == nullptr || apart_s < std::abs(nearest->time_s - a.time_s)) nearest = *at;
    }
    return nearest;
  }

 private:
  std::vector<const Fix*> by_time_;
  std::unordered_map<std::int64_t, std::vector<const Fix*>> by_epoch_;
};

}  // namespace

double set_ray_speeds(Trajectory& t, const SharedState& state, const SpeedProfile& profile) {
  double largest_m = 0.0;
  for (ArrivalObservation& a : t.arrivals) {
    if (!t.nodes[a.node].placed) continue;
    const Eigen::Vector3d receiver_m =
        pose_at(t, a.node, a.alpha) * state.receiver_p_vehicle_m[a.receiver.index()];
    const Eigen::Vector3d& beacon_m = state.beacon_p_map_m[a.beacon.index()];
    const double speed_mps = profile.effective_speed_mps(receiver_m, beacon_m);
    largest_m =
        std::max(largest_m, (receiver_m - beacon_m).norm() * std::abs(a.model_speed_mps / speed_mps - 1));
    a.model_speed_mps = speed_mps;
  }
  return largest_m;
}

std::vector<Arrival> at_one_speed(std::span<const Arrival> arrivals, std::span<const Fix> fixes,
                                  const Deployment& deployment) {
  const FixOf fix_of(fixes);
  std::vector<Arrival> changed(arrivals.begin(), arrivals.end());
  const double one_mps = deployment.speed_mps(deployment.medium.temperature_degC);
  for (Arrival& a : changed) {
    const Fix* fix = fix_of(a);
    if (fix == nullptr) continue;
    const Eigen::Vector3d receiver_m =
        fix->T_map_vehicle * deployment.receivers[a.receiver.index()].position_m;
    const Eigen::Vector3d& beacon_m = deployment.beacons[a.beacon.index()].position_m;
    const double ray_mps =
        deployment.medium.profile->effective_speed_mps(receiver_m, beacon_m) + deployment.speed_offset_mps;
    a.tof_s += deployment.timing.legs() * (receiver_m - beacon_m).norm() * (1 / one_mps - 1 / ray_mps);
  }
  return changed;
}

}  // namespace octant
