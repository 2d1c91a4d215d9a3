// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

// Description of a table of times of flight or distances: its columns, their units, its clock, and its rows.
namespace octant::io {

/// Rule for a column of tof.csv: target = factor * source + offset; ids are copied. Without a factor, the
/// unit at the end of the source's name is converted (`timestamp_ms`, `Laufzeit [ms]`). Times may be dates
/// (2026-06-11 11:33:48.686).
struct ColumnRule {
  std::string target;  ///< time_s, beacon, tof_s, distance_m, epoch, vehicle, receiver, amplitude_v,
                       ///< temperature_degC, received_s
  /// Name of a column, or its number from 1 ("#3"). For tof_s and distance_m it may be a pattern
  /// ("r_{beacon}") that matches one column for each beacon. For time_s it may be a column of dates and one
  /// of times of day ("Date+Time").
  std::string source;
  std::optional<double> factor = {};
  std::string beacon = {}, receiver = {};  ///< names of a column of one beacon
};

/// A condition on the cells of a column; rows that do not meet it are left out.
struct RowCondition {
  std::string column;    ///< its name, or its number ("#3")
  std::string relation;  ///< = != < <= > >=
  std::string value;     ///< compared as a number if both are numbers, otherwise as text; no text is less or
                         ///< more than a number
};

struct TableMapping {
  std::vector<ColumnRule> columns;       ///< empty: guessed from the header and the cells
  std::vector<std::string> ignore;       ///< beacons whose rows are left out, such as those of a neighbour
  std::vector<RowCondition> where = {};  ///< all are met by the rows that are used
  bool no_header = false;                ///< the first line is a row; false: recognised
  std::string time_format = {};          ///< of kTimeFormats; empty: recognised
  std::string decimal = {};              ///< "point" or "comma"; empty: recognised
  /// Cells without a measurement, "none" for no such cells; empty: recognised.
  std::vector<std::string> no_value = {};
  std::optional<double> period_s = {};  ///< between lines of a table without a time
};

/// Formats of times: units, serial dates of Excel and of MATLAB, the 40-bit counter of a DW1000, and the
/// order of dates with slashes.
inline constexpr const char* kTimeFormats[] = {"s",      "ms",     "us",  "ns", "excel",
                                               "matlab", "dw1000", "dmy", "mdy"};

}  // namespace octant::io
