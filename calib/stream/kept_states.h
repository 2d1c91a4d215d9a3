// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// States between the passes over a log: in the plane x, y, heading, in space position and rotation, then
/// further numbers of a state (cycle offset, velocity). NaN as the third number: not placed.
class KeptStates {
 public:
  void clear() { numbers_.clear(); }
  void reserve(const Trajectory& like, std::size_t states) { numbers_.reserve(states * numbers_of(like)); }
  [[nodiscard]] std::size_t count(const Trajectory& like) const { return numbers_.size() / numbers_of(like); }

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

/// Data of a trajectory that are kept between the passes over a log.
class KeptTrajectory {
 public:
  /// Keeps the states [first_node, last_node), the given number of arrivals, and the bearings from the first
  /// state on that begin before the last one, or all to the end of the trajectory.
  void keep(const Trajectory& t, std::size_t first_node, std::size_t last_node, std::size_t first_arrival,
            std::size_t arrivals) {
    states_.clear();
    rejections_.clear();
    states_.reserve(t, last_node - first_node);
    for (std::size_t k = first_node; k < last_node; ++k) states_.add(t, t.nodes[k]);
    for (std::size_t i = first_arrival; i < first_arrival + arrivals; ++i)
      rejections_.push_back(t.arrivals[i].rejection);
    for (const BearingObservation& b : t.bearings)
      if (b.node >= first_node && (b.node + 1 < last_node || last_node == t.nodes.size()))
        rejections_.push_back(b.rejection);
  }
  void keep(const Trajectory& t) { keep(t, 0, t.nodes.size(), 0, t.arrivals.size()); }

  /// Returns true if a trajectory has the same number of states and observations.
  [[nodiscard]] bool fits(const Trajectory& t) const {
    return states_.count(t) == t.nodes.size() && rejections_.size() == t.arrivals.size() + t.bearings.size();
  }
  void restore(Trajectory& t) const {
    for (std::size_t k = 0; k < t.nodes.size(); ++k) states_.put(t, k, t.nodes[k]);
    std::size_t mark = 0;
    for (ArrivalObservation& a : t.arrivals) a.rejection = rejections_[mark++];
    for (BearingObservation& b : t.bearings) b.rejection = rejections_[mark++];
  }

  KeptStates& states() { return states_; }
  std::vector<Rejection>& rejections() { return rejections_; }

 private:
  KeptStates states_;
  std::vector<Rejection> rejections_;  ///< rejections of arrivals, then of bearings
};

}  // namespace octant::calib
