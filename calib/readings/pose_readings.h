// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/readings/reading.h"

namespace octant::calib {

/// Hypotheses that measured poses are in a left-handed frame, as some programs write them: y or x reversed, x
/// and y exchanged (north, east, down), headings clockwise; and, if the poses tumble, quaternions in another
/// order. Empty without measured poses.
[[nodiscard]] std::vector<Reading> other_pose_frames(const std::vector<MeasurementLog>& runs);
/// Hypotheses that the positions of measured poses are in centimetres, millimetres, feet or inches.
[[nodiscard]] std::vector<Reading> other_pose_units(const std::vector<MeasurementLog>& runs);
/// Returns true if at least one measured pose in ten is on its side or upside down. No ground vehicle, drone
/// or ship moves so, but quaternions in another order look like this.
[[nodiscard]] bool do_poses_tumble(const std::vector<MeasurementLog>& runs);
/// Hypotheses on a time lag of the measured poses of a moving vehicle; empty without such poses. A lag that
/// leaves arrivals without a pose is excluded.
[[nodiscard]] std::vector<ReadingFamily> poses_stamped_late(const std::vector<MeasurementLog>& runs);
/// Hypothesis that the measured poses are of another point of the vehicle (prism, antenna) than its origin.
/// @param lever_m  that point in the vehicle's frame
[[nodiscard]] Reading poses_of_other_point(const std::vector<MeasurementLog>& runs,
                                           const Eigen::Vector3d& lever_m);
/// Rotation about the vertical and translation from one set of points to another, by least squares (Umeyama
/// 1991, in the plane and without a scale). No value if the points do not determine the rotation.
[[nodiscard]] std::optional<Pose> frame_between(const std::vector<Eigen::Vector3d>& from,
                                                const std::vector<Eigen::Vector3d>& to);
/// Hypothesis that the frame of the measured poses is rotated or shifted relative to the control points.
/// @param T_map_frame  pose of that frame in the map
[[nodiscard]] Reading poses_of_other_frame(const std::vector<MeasurementLog>& runs, const Pose& T_map_frame);
/// Hypothesis that the measured poses of stops have an unknown error; these poses are ignored. Empty without
/// poses, and for drives, which depend on them.
[[nodiscard]] std::vector<Reading> without_poses(const std::vector<MeasurementLog>& runs);

}  // namespace octant::calib
