// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the columns of a table that are read.

#include <optional>
#include <string>
#include <vector>

#include "io/import/imported_log.h"
#include "io/table/table_layout.h"
#include "io/table/table_time.h"

namespace octant::io {

struct TableColumn {
  std::size_t cell;
  std::string name;  ///< as messages say it
  const TofColumn* target;
  UnitConversion unit;
  std::string beacon, receiver;  ///< names of a column of one beacon

  /// True for a time of flight or a distance.
  [[nodiscard]] bool is_value() const { return target->name == "tof_s" || target->name == "distance_m"; }
};

struct TableColumns {
  std::vector<TableColumn> all;
  std::optional<std::size_t> time_cell;
  std::optional<std::size_t> clock_cell;  ///< time of day, if time_cell is a date
  TimeColumn time;
  std::optional<double> below_unit_s;  ///< unit of clock_cell, if it is a number that is added to the time
  bool one_each = false;               ///< a column for each beacon
  std::vector<double> no_values;       ///< numbers that stand for no measurement
  std::vector<std::string> no_words;

  [[nodiscard]] std::string time_text(const std::vector<std::string>& cells) const;
};

struct ColumnSource {
  bool of_tof_csv = false;   ///< the table has the columns of tof.csv
  bool are_guessed = false;  ///< the columns are guessed; so is the unit of the time
};

/// Finds the columns that a mapping names. Errors: kBadInput: columns that are missing, units that are not
/// known.
[[nodiscard]] Result<TableColumns> columns_of(const TableLayout& layout, const std::string& path,
                                              const TableMapping& mapping, ColumnSource source);

/// Warnings about columns whose unit is not stated: names that may end with a unit, and values that no
/// deployment has.
[[nodiscard]] std::vector<std::string> notes_of_units(const TableColumns& columns,
                                                      const TableMapping& mapping,
                                                      const std::vector<ImportedArrival>& arrivals);

}  // namespace octant::io
