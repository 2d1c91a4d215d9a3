// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "io/table/table_mapping.h"
#include "models/support/result.h"

// Mappings of tables as text: the words of --columns and --where, and files.
namespace octant::io {

/// "time=timestamp_ms*1e-3,beacon=anchor,distance=distance_cm*1e-2". Targets may go without their unit.
/// Tables with one column for each beacon: "distance=r_{beacon}" or "distance:A1=r1,distance:A2=r2" (with a
/// receiver: distance:A1:front=...). Tables without a header line: "time=#1,distance:A1=#2". Errors:
/// kUsage, naming the word.
[[nodiscard]] Result<TableMapping> mapping_from_words(std::string_view words);
/// A condition of --where: "valid=1", "rssi>=-90". Errors: kUsage.
[[nodiscard]] Result<RowCondition> condition_from_word(std::string_view word);
/// Reads a mapping from a file: octant_columns: 1, columns: {time_s: ..., distance_m: ... or {A1: ...}},
/// ignore: [...].
[[nodiscard]] Result<TableMapping> read_mapping(const std::string& path);
[[nodiscard]] std::string mapping_to_yaml(const TableMapping& mapping);
/// The argument of --columns for a mapping.
[[nodiscard]] std::string mapping_to_words(const TableMapping& mapping);

/// Options of `octant convert` for the columns and for the formats of times and numbers.
[[nodiscard]] std::string mapping_to_options(const TableMapping& mapping);
/// Error of a mapping that names no beacon or no value, or several columns for one of tof.csv. A table
/// without a time has a period.
[[nodiscard]] Result<void> check_mapping(const TableMapping& mapping);

}  // namespace octant::io
