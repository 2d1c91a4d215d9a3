// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/readings/reading.h"

namespace octant::calib {

/// Measured poses in a left-handed frame, as other programs write them: y or x the other way round, x and y
/// exchanged (north, east, down), headings clockwise; their quaternions in another order, where they tumble.
/// Returns an empty list for recordings without measured poses.
[[nodiscard]] std::vector<Reading> other_pose_frames(const std::vector<MeasurementLog>& runs);
/// Measured poses whose positions are in centimetres, millimetres, feet or inches.
[[nodiscard]] std::vector<Reading> other_pose_units(const std::vector<MeasurementLog>& runs);
/// Returns true where one measured pose in ten lies on its side or upside down, as no ground vehicle, drone
/// or ship does, and as quaternions do that are read in another order.
[[nodiscard]] bool do_poses_tumble(const std::vector<MeasurementLog>& runs);
/// Measured poses of a moving vehicle that are stamped late or early; none where there are none. A lag that
/// leaves arrivals without a pose explains nothing.
[[nodiscard]] std::vector<ReadingFamily> poses_stamped_late(const std::vector<MeasurementLog>& runs);
/// Measured poses of another point of the vehicle (the prism, the antenna) than its origin.
/// @param lever_m  that point in the vehicle's frame
[[nodiscard]] Reading poses_of_other_point(const std::vector<MeasurementLog>& runs,
                                           const Eigen::Vector3d& lever_m);
/// Turn about the vertical and shift that take points of one frame to those of another, by least squares
/// (Umeyama 1991, in the plane and without a scale); nothing of points that do not tell a turn.
[[nodiscard]] std::optional<Pose> frame_between(const std::vector<Eigen::Vector3d>& from,
                                                const std::vector<Eigen::Vector3d>& to);
/// Measured poses in a frame that is turned or shifted against the control points'.
/// @param T_map_frame  of that frame in the map
[[nodiscard]] Reading poses_of_other_frame(const std::vector<MeasurementLog>& runs, const Pose& T_map_frame);
/// Without the measured poses of stops, which then fit in no way that is known; none where there are no
/// poses, or of a drive, whose ways hang on them.
[[nodiscard]] std::vector<Reading> without_poses(const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
