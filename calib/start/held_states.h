// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Pseudo-observations of poses, for as long as it lives: then the trajectories have their own again.
class HeldStates {
 public:
  HeldStates(const HeldStates&) = delete;
  HeldStates& operator=(const HeldStates&) = delete;

 protected:
  /// Holds the placed states of some trajectories near their present values; a segment's own measured poses
  /// stay, and are enough.
  /// @param trajectories  null: holds nothing
  /// @param like          the sigmas; infinite: not held
  HeldStates(std::vector<Trajectory>* trajectories, bool (*is_held)(const Trajectory&),
             const PoseObservation& like);
  ~HeldStates();

 private:
  static void hold(Trajectory& trajectory, const PoseObservation& like);

  std::vector<Trajectory>* trajectories_;
  std::vector<std::vector<PoseObservation>> poses_;
  std::vector<std::vector<Segment>> segments_;
};

/// Holds the headings of stationary epochs. A receiver that faces its beacon is nearer to it than the
/// vehicle's centre, so beacons that are all off by more than the array is large make a heading turned by
/// half a circle explain the ranges better; the search tells headings from differences between receivers,
/// which do not depend on the beacons.
class HeldHeadings : public HeldStates {
 public:
  explicit HeldHeadings(std::vector<Trajectory>* trajectories);
};

/// Whether a trajectory is a drive in space by odometry alone, the path of which can be held.
[[nodiscard]] bool can_be_held(const Trajectory& trajectory);

/// Holds the paths of drives in space. Their heights and tilts are weakly observable: states that are free
/// settle towards beacons that are off, which then follow them into a tilted image of both.
class HeldPaths : public HeldStates {
 public:
  /// @param place_m, attitude_rad  sigmas of each state
  HeldPaths(std::vector<Trajectory>& trajectories, double place_m, double attitude_rad);
};

}  // namespace octant::calib
