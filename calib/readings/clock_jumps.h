// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/log_health.h"
#include "calib/readings/reading.h"
#include "calib/solution/solve_options.h"

namespace octant::calib {

enum class LogHalf { kFirst, kLast };

/// Jumps of a clock during a recording, as one half of it shows them: the half is adjusted by itself, and
/// every stop then has a clock offset of its own (four beacons or more heard); along a drive, what its ranges
/// of a moment are off by together is looked at. An adjustment of the whole bends to a jump, so that its
/// offsets no longer show it; of two halves one is without it. Evenly spread stops are looked at, some
/// hundreds, or stretches of a drive. A gross jump is first taken back as the ranges alone show it. None
/// where each epoch has a clock of its own, or none is told.
[[nodiscard]] std::vector<ClockStep> clock_jumps(const Site& site, const MeasurementLog& run, LogHalf half,
                                                 const SolveOptions& options = {});

/// Takes the jumps away: times of flight after each as the clock before it would have had them.
void without_jumps(const std::vector<ClockStep>& jumps, MeasurementLog& run);
/// A clock that jumped between two stops, taken back, as either half of the recordings shows it; none where
/// none is seen.
[[nodiscard]] std::vector<Reading> jumped_clocks(const Site& site, const std::vector<MeasurementLog>& runs,
                                                 const SolveOptions& options);

/// A clock that drifts so much that no stop fits as stated: with a clock offset of its own each stop has a
/// place, and the offsets lie on a line. None of drives, of clocks that have such offsets by design, and
/// where the offsets show no line.
[[nodiscard]] std::vector<Reading> drifting_clocks(const Site& site, const std::vector<MeasurementLog>& runs,
                                                   const SolveOptions& options);

}  // namespace octant::calib
