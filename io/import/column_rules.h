// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace octant::io {

/// Rule for a column of tof.csv: target = factor * source + offset; ids are copied. Without a factor, the
/// unit at the end of the source's name is converted (`timestamp_ms`, `Laufzeit [ms]`). Times may be dates
/// (2026-06-11 11:33:48.686).
struct ColumnRule {
  std::string target;  ///< time_s, beacon, tof_s, distance_m, epoch, vehicle, receiver, amplitude_v,
                       ///< temperature_degC, received_s
  /// Name of a column, or its number from 1 ("#3"). For tof_s and distance_m it may be a pattern
  /// ("r_{beacon}") that matches one column for each beacon.
  std::string source;
  std::optional<double> factor = {};
  std::string beacon = {}, receiver = {};  ///< names of a column of one beacon
};

struct TableMapping {
  std::vector<ColumnRule> columns;
  std::vector<std::string> ignore;  ///< beacons whose rows are left out, such as those of a neighbour
};

}  // namespace octant::io
