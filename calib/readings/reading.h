// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "calib/calibrate.h"
#include "models/contradiction.h"

namespace octant::calib {

/// The statements as they might be meant: another site, or other recordings.
struct Reading {
  Contradiction what;                                         ///< if it is what is meant; without `sigmas`
  std::function<Site(const Site&)> site;                      ///< empty: as stated
  std::function<void(std::size_t run, MeasurementLog&)> log;  ///< of each run; empty: as recorded
  bool is_of_whole =
      false;  ///< `log` is of the whole recording, before a part is taken and rows are summed up
};

/// Times there and back for one-way times, or the other way round; none where each epoch has a clock of its
/// own.
[[nodiscard]] std::vector<Reading> other_ranging(const Site& site);

/// Positions of beacons, receivers or both in centimetres, millimetres, feet, inches.
/// @param some_only  only those beacons that are of another order of magnitude than the rest, or that the
/// ranges tell apart from it (mixed_units.h)
[[nodiscard]] std::vector<Reading> other_units(const Site& site, const std::vector<MeasurementLog>& runs,
                                               bool some_only);

/// Two of a few control points at each other's places. Of three that are all the datum each can be blamed by
/// itself, as it may move to where it agrees with the two others; an exchange explains the same with nothing
/// to adjust. None where there are more than a few.
[[nodiscard]] std::vector<Reading> exchanged_points(const Site& site);

/// Measured poses in a mirrored frame; none where there are no poses.
[[nodiscard]] std::vector<Reading> other_pose_frames(const std::vector<MeasurementLog>& runs);

/// Measured poses of a moving vehicle whose clock is behind the arrivals' (`lag_s` > 0) or ahead of it.
[[nodiscard]] Reading poses_of_other_clock(const std::vector<MeasurementLog>& runs, double lag_s);

/// Measured poses of another point of the vehicle (the prism, the antenna) than its origin.
/// @param lever_m  that point in the vehicle's frame
[[nodiscard]] Reading poses_of_other_point(const std::vector<MeasurementLog>& runs,
                                           const Eigen::Vector3d& lever_m);

/// Measured poses in a frame that is turned or shifted against the control points'.
/// @param T_map_frame  of that frame in the map
[[nodiscard]] Reading poses_of_other_frame(const std::vector<MeasurementLog>& runs, const Pose& T_map_frame);

/// Odometry with the turns or the way of another sign, in degrees, centimetres or millimetres; none where
/// there is none, or it is in space.
[[nodiscard]] std::vector<Reading> other_odometry(const std::vector<MeasurementLog>& runs);

/// Without the measured poses of stops, which then fit in no way that is known; none where there are no
/// poses, or of a drive, whose ways hang on them.
[[nodiscard]] std::vector<Reading> without_poses(const std::vector<MeasurementLog>& runs);

/// Receivers exchanged, mirrored, turned.
[[nodiscard]] std::vector<Reading> other_wirings(const Site& site, const Solution& solution);

/// A clock that jumped between two stops, taken back, as either half of the recordings shows it
/// (clock_jumps.h); none where none is seen.
[[nodiscard]] std::vector<Reading> jumped_clocks(const Site& site, const std::vector<MeasurementLog>& runs,
                                                 const SolveOptions& options);

}  // namespace octant::calib
