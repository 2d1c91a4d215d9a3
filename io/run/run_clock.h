// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the one clock of the files of a run folder.

#include <vector>

#include "io/tof/continued_clock.h"
#include "models/run.h"

namespace octant::io {

/// Moves the rows of a file by one period where the clock started again between the first row of tof.csv and
/// the first row of this file: each file is continued from its own first row.
/// @param first_arrival_s  time of the first row of tof.csv
/// @param clock            of the file or of tof.csv, whichever started again
template <class Row>
void align_periods(std::vector<Row>& rows, double first_arrival_s, const ContinuedClock& clock) {
  if (clock.period_s() == 0.0 || rows.empty()) return;
  const double apart = (first_arrival_s - rows.front().time_s) / clock.period_s();
  if (!(apart > 0.5 && apart < 1.5) && !(apart < -0.5 && apart > -1.5)) return;
  for (Row& row : rows) row.time_s += apart > 0.0 ? clock.period_s() : -clock.period_s();
}

/// Restores the order of a recording whose rows were sorted by the times of a clock that started again, so
/// that its second half is first. The halves are one long gap apart, all other gaps are short (at most
/// kLongestGapOfPeriod), and the last row precedes the first one by no more than twice the longest of these,
/// across the restart. Adds a warning.
void restore_sorted_restart(MeasurementLog& log, const std::string& file);

}  // namespace octant::io
