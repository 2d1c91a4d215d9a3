// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/log_health.h"
#include "calib/readings/reading.h"
#include "calib/solution/solve_options.h"

namespace octant::calib {

enum class LogHalf { kFirst, kLast };

/// Finds jumps of a clock during a recording by one half of it. The half is adjusted by itself. Each stop
/// with four or more beacons then gets its own clock offset; along a drive, the common deviation of the
/// ranges at each time is examined. An adjustment of the whole recording would adapt to the jump and hide it,
/// but one of the halves is free of it. Some hundred evenly spread stops, or segments of a drive, are
/// examined. Large jumps that the ranges alone show are corrected first.
/// @return empty if each epoch has its own clock offset, or if no offset can be determined
[[nodiscard]] std::vector<ClockStep> clock_jumps(const Site& site, const MeasurementLog& run, LogHalf half,
                                                 const SolveOptions& options = {});

/// Corrects the times of flight after each jump to the clock before it.
void without_jumps(const std::vector<ClockStep>& jumps, MeasurementLog& run);
/// Hypotheses that a clock jumped, with the jumps that either half of the recordings shows; empty without
/// jumps.
[[nodiscard]] std::vector<Reading> jumped_clocks(const Site& site, const std::vector<MeasurementLog>& runs,
                                                 const SolveOptions& options);

/// Hypotheses that a clock drifts so much that no stop agrees. With separate clock offsets the stops have
/// poses, and the offsets are linear in time. Empty for drives, for clocks with an offset for each epoch, and
/// if the offsets are not linear.
[[nodiscard]] std::vector<Reading> drifting_clocks(const Site& site, const std::vector<MeasurementLog>& runs,
                                                   const SolveOptions& options);

}  // namespace octant::calib
