// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Headings of the epochs of planar stops, to be compared with later ones; NaN where an epoch has no pose.
[[nodiscard]] std::vector<std::vector<double>> epoch_headings_rad(
    const std::vector<Trajectory>& trajectories);

/// Returns true if arrivals determine the heading of a vehicle: two receivers apart in the plane, or one off
/// the origin of measured poses.
/// @param measured  its runs have measured poses or odometry
[[nodiscard]] bool has_heading(const Site& site, VehicleId vehicle, bool measured);
/// Returns true if the initial heading of an epoch differs by more than 90 degrees from the adjusted one.
[[nodiscard]] bool is_flipped(const Node& node, double before_rad);
/// Number of epochs of a run in words; empty for zero.
[[nodiscard]] std::vector<std::string> flips_in_words(const MeasurementLog& run,
                                                      const std::vector<std::int64_t>& epochs);

/// Descriptions of heading flips for the user: epochs whose initial heading differed by more than 90 degrees
/// from the adjusted one and was reversed.
/// @param before  from epoch_headings_rad, of the start
[[nodiscard]] std::vector<std::string> report_flips(const Site& site, const std::vector<MeasurementLog>& runs,
                                                    const std::vector<Trajectory>& trajectories,
                                                    const std::vector<std::vector<double>>& before);

}  // namespace octant::calib
