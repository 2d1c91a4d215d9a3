// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Where states are between the readings of a log: in the plane x, y, heading, in space the place and the
/// rotation, then what else a state has (cycle offset, velocity). NaN instead of the third: no place.
class KeptStates {
 public:
  void clear() { numbers_.clear(); }
  void reserve(const Trajectory& like, std::size_t states) { numbers_.reserve(states * numbers_of(like)); }
  [[nodiscard]] std::size_t count(const Trajectory& like) const { return numbers_.size() / numbers_of(like); }
  /// Whether a state of such a trajectory has a place. @param state  a number from 0
  [[nodiscard]] bool has_place(const Trajectory& like, std::size_t state) const {
    return !std::isnan(numbers_[state * numbers_of(like) + 2]);
  }

  void add(const Trajectory& like, const Node& node) {
    const Pose& T = node.T_map_vehicle;
    numbers_.push_back(T.translation_m.x());
    numbers_.push_back(T.translation_m.y());
    if (like.motion == Motion::kPlanar) {
      numbers_.push_back(node.placed ? T.heading_rad() : NAN);
    } else {
      numbers_.push_back(node.placed ? T.translation_m.z() : NAN);
      for (Eigen::Index i = 0; i < 4; ++i) numbers_.push_back(T.rotation.coeffs()[i]);
    }
    if (like.has_cycle_offset) numbers_.push_back(node.cycle_offset_s);
    for (Eigen::Index i = 0; like.motion_prior && i < 3; ++i) numbers_.push_back(node.velocity[i]);
  }
  void put(const Trajectory& like, std::size_t state, Node& node) const {
    const double* from = numbers_.data() + state * numbers_of(like);
    node.placed = !std::isnan(from[2]);
    if (!node.placed) return;
    if (like.motion == Motion::kPlanar) {
      node.T_map_vehicle = Pose::planar(from[0], from[1], from[2]);
      from += 3;
    } else {
      node.T_map_vehicle.translation_m = {from[0], from[1], from[2]};
      node.T_map_vehicle.rotation = Eigen::Quaterniond(from[6], from[3], from[4], from[5]);
      from += 7;
    }
    if (like.has_cycle_offset) node.cycle_offset_s = *from++;
    if (like.motion_prior) node.velocity = {from[0], from[1], from[2]};
  }

 private:
  [[nodiscard]] static std::size_t numbers_of(const Trajectory& like) {
    return (like.motion == Motion::kPlanar ? 3U : 7U) + (like.has_cycle_offset ? 1U : 0U) +
           (like.motion_prior ? 3U : 0U);
  }
  std::vector<double> numbers_;
};

}  // namespace octant::calib
