// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/finding.h"
#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Jumps that the log alone shows: the ranges of most beacons change together, in one direction, by more than
/// the vehicle can have moved in between (5 m/s, or its odometry plus a tenth). Small jumps between stops far
/// apart in time are not detectable in this way.
[[nodiscard]] std::vector<ClockStep> steps_in_ranges(const Site& site, const MeasurementLog& run);

/// Returns true if there is a jump in any of the runs.
[[nodiscard]] bool ranges_show_a_jump(const Site& site, const std::vector<MeasurementLog>& runs);

/// If the fit of a stop is rough (echoes), steps below a tenth of a metre are not significant.
inline constexpr double kSmallestStepM = 0.1;

/// Jumps that the beacons' geometry shows: each stop is solved with a clock offset of its own (four beacons
/// or more), and the offsets of stops in a row are compared before and after.
/// @param trajectories  with states near the truth; rejected arrivals take part, as a jump may be why they
/// were  @param smallest_m  of sound's way
[[nodiscard]] std::vector<ClockStep> steps_between_stops(const std::vector<Trajectory>& trajectories,
                                                         std::size_t run, const SharedState& state,
                                                         double smallest_m = kSmallestStepM);

/// Jumps along drives: the common residual of the ranges of a moment, from a few dozen arrivals of four
/// beacons or more, is compared before and after, moment by moment.
/// @param trajectories  with states from odometry and all ranges together: ranges with little weight hardly
/// move them with the clock
/// @param smallest_m  smallest jump, as a distance
[[nodiscard]] std::vector<ClockStep> steps_along_drives(const std::vector<Trajectory>& trajectories,
                                                        const SharedState& state, double smallest_m);

}  // namespace octant::calib
