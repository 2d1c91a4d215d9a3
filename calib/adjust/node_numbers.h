// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// What moves of a state, as numbers that ranks exchange and readings keep: place, rotation, cycle offset,
/// velocity, and whether it has a place.
inline constexpr std::size_t kNumbersOfNode = 12;

inline void put_numbers(const Node& node, double* to) {
  const Pose& T = node.T_map_vehicle;
  const double numbers[kNumbersOfNode] = {T.translation_m.x(), T.translation_m.y(), T.translation_m.z(),
                                          T.rotation.x(),      T.rotation.y(),      T.rotation.z(),
                                          T.rotation.w(),      node.cycle_offset_s, node.velocity.x(),
                                          node.velocity.y(),   node.velocity.z(),   node.placed ? 1.0 : 0.0};
  std::copy(numbers, numbers + kNumbersOfNode, to);
}

inline void read_numbers(const double* from, Node& node) {
  node.T_map_vehicle.translation_m = {from[0], from[1], from[2]};
  node.T_map_vehicle.rotation = Eigen::Quaterniond(from[6], from[3], from[4], from[5]);
  node.cycle_offset_s = from[7];
  node.velocity = {from[8], from[9], from[10]};
  node.placed = from[11] != 0.0;
}

}  // namespace octant::calib
