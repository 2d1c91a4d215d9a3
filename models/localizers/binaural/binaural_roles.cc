// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "models/localizers/binaural/binaural.h"
#include "models/physics/plane.h"

namespace octant {
namespace {

constexpr double kSameLength =
    1e-3;  // smallest difference between two distances that identifies the transducers
constexpr double kMinSine =
    0.1;  // smallest sine of the angle between the receivers' baseline and their direction

/// Indices of transmitter, left and right receiver among three points.
Result<std::array<std::size_t, 3>> order(const std::array<Eigen::Vector2d, 3>& p,
                                         const Eigen::Vector2d& facing, const std::string& who) {
  std::array<double, 3> opposite_m{};  // length of the side opposite to each point
  for (std::size_t i = 0; i < 3; ++i) opposite_m[i] = (p[(i + 1) % 3] - p[(i + 2) % 3]).norm();
  std::size_t t = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (opposite_m[i] > opposite_m[t]) t = i;
  std::size_t left = (t + 1) % 3, right = (t + 2) % 3;
  for (const std::size_t i : {left, right}) {
    if (opposite_m[t] - opposite_m[i] < kSameLength)
      return bad_input("binaural: " + who + " has no two elements that stand farthest apart",
                       "a transmitter between two receivers");
  }
  const double side = cross(facing, p[left] - p[right]) / opposite_m[t];
  if (std::abs(side) < kMinSine)
    return bad_input("binaural: " + who + "'s receivers stand behind each other", "receivers side by side");
  if (side < 0) std::swap(left, right);
  return std::array<std::size_t, 3>{t, left, right};
}

}  // namespace

Result<BinauralRoles> binaural_roles(const Deployment& deployment, const BinauralOptions& options) {
  if (deployment.motion != Motion::kPlanar)
    return bad_input("binaural: the motion is spatial", "planar motion");
  if (deployment.timing.clock != Clock::kSynchronised || deployment.timing.ranging != Ranging::kOneWay)
    return bad_input("binaural: times of flight are not synchronised and one-way",
                     "a radio mark of the firing");
  std::vector<std::size_t> beacons, receivers;
  for (std::size_t b = 0; b < deployment.beacons.size(); ++b)
    if (deployment.beacons[b].status != BeaconStatus::kUndetermined) beacons.push_back(b);
  for (std::size_t r = 0; r < deployment.receivers.size(); ++r)
    if (deployment.receivers[r].vehicle == options.vehicle) receivers.push_back(r);
  if (beacons.size() != 3)
    return bad_input("binaural: " + std::to_string(beacons.size()) + " usable beacons",
                     "three: robot 2's transmitter and its two receivers");
  if (receivers.size() != 3)
    return bad_input("binaural: " + std::to_string(receivers.size()) + " receivers on the vehicle",
                     "three: robot 1's transmitter and two receivers");

  BinauralRoles roles;
  std::array<Eigen::Vector2d, 3> p2, p1;
  Eigen::Vector2d axes(0, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    const DeploymentReceiver& receiver = deployment.receivers[receivers[i]];
    p2[i] = deployment.beacons[beacons[i]].position_m.head<2>();
    p1[i] = receiver.position_m.head<2>();
    if (receiver.axis) axes += receiver.axis->head<2>();
  }
  if (options.facing_vehicle) axes = *options.facing_vehicle;
  if (axes.norm() > 1e-6) roles.facing1 = axes.normalized();
  const auto two = order(p2, options.facing_map.normalized(), "robot 2");
  if (!two) return fail(two.error());
  const auto one = order(p1, roles.facing1, "robot 1");
  if (!one) return fail(one.error());
  roles.transmitter2 = BeaconId(beacons[(*two)[0]]);
  roles.left2 = BeaconId(beacons[(*two)[1]]);
  roles.right2 = BeaconId(beacons[(*two)[2]]);
  roles.transmitter1 = ReceiverId(receivers[(*one)[0]]);
  roles.left1 = ReceiverId(receivers[(*one)[1]]);
  roles.right1 = ReceiverId(receivers[(*one)[2]]);
  return roles;
}

Result<void> binaural_fits(const Deployment& deployment) {
  const auto roles = binaural_roles(deployment);
  if (!roles) return fail(roles.error());
  return {};
}

}  // namespace octant
