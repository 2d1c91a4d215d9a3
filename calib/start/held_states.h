// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Pseudo-observations of poses during the lifetime of the object; afterwards the trajectories have their own
/// again.
class HeldStates {
 public:
  /// Constrains the headings of stationary epochs. A receiver on the side of a beacon is nearer to it than
  /// the vehicle's centre. If all beacons are wrong by more than the size of the array, a heading rotated by
  /// half a turn therefore explains the ranges better. The search determines headings from differences
  /// between receivers, which do not depend on the beacons.
  /// @param trajectories  null: no constraint
  [[nodiscard]] static HeldStates headings(std::vector<Trajectory>* trajectories);
  /// Constrains the paths of drives in space. Their heights and tilts are weakly observable: free states
  /// adapt to wrong beacons, which then follow them into a tilted image of both.
  /// @param place_m, attitude_rad  sigmas of each state
  [[nodiscard]] static HeldStates paths(std::vector<Trajectory>& trajectories, double place_m,
                                        double attitude_rad);

  HeldStates(const HeldStates&) = delete;
  HeldStates& operator=(const HeldStates&) = delete;
  ~HeldStates();

 private:
  /// Constrains the placed states of some trajectories to their present values; segments with measured poses
  /// keep these, which are sufficient.
  /// @param like  the sigmas; infinite: no constraint
  HeldStates(std::vector<Trajectory>* trajectories, bool (*is_held)(const Trajectory&),
             const PoseObservation& like);
  static void hold(Trajectory& trajectory, const PoseObservation& like);

  std::vector<Trajectory>* trajectories_;
  std::vector<std::vector<PoseObservation>> poses_;
  std::vector<std::vector<Segment>> segments_;
};

/// Returns true if a trajectory is a drive in space with odometry only, whose path can be constrained.
[[nodiscard]] bool can_be_held(const Trajectory& trajectory);

}  // namespace octant::calib
