// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/speed/one_speed.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "models/localizers/common/open_attitude.h"

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

/// A point at z = 0 at a distance from a beacon.
Eigen::Vector3d at_surface(const Eigen::Vector3d& beacon_m, double distance_m) {
  const double horizontal_m = std::sqrt(std::max(0.0, distance_m * distance_m - beacon_m.z() * beacon_m.z()));
  return {beacon_m.x() + horizontal_m, beacon_m.y(), 0.0};
}

/// Receiver of a fix in the map. A fix with open attitude has the centre of the receivers.
Eigen::Vector3d receiver_of(const Fix& fix, const DeploymentReceiver& receiver,
                            const Deployment& deployment) {
  if (!has_open_attitude(fix)) return fix.T_map_vehicle * receiver.position_m;
  return fix.T_map_vehicle.translation_m + receiver.position_m -
         receiver_centre_m(deployment, receiver.vehicle);
}

}  // namespace

std::vector<Arrival> at_one_speed(std::span<const Arrival> arrivals, std::span<const Fix> fixes,
                                  const Deployment& deployment) {
  const FixOf fix_of(fixes);
  std::vector<Arrival> changed(arrivals.begin(), arrivals.end());
  const double one_mps = deployment.speed_mps(deployment.medium.temperature_degC);
  const double legs = deployment.timing.legs();
  for (Arrival& a : changed) {
    const Fix* fix = fix_of(a);
    const Eigen::Vector3d& beacon_m = deployment.beacons[a.beacon.index()].position_m;
    const DeploymentReceiver& receiver = deployment.receivers[a.receiver.index()];
    const Eigen::Vector3d receiver_m = fix != nullptr ? receiver_of(*fix, receiver, deployment)
                                                      : at_surface(beacon_m, a.tof_s / legs * one_mps);
    const double ray_mps =
        deployment.medium.profile->effective_speed_mps(receiver_m, beacon_m) + deployment.speed_offset_mps;
    a.tof_s += legs * (receiver_m - beacon_m).norm() * (1 / one_mps - 1 / ray_mps);
  }
  return changed;
}

}  // namespace octant
