// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/table/table_log.h"

namespace octant::io::test {

/// A table, the words of --columns, and the tof.csv that it becomes.
struct TableCase {
  const char *name, *words, *table, *csv;
};

/// The tof.csv that a table becomes, or the message of its error.
inline std::string csv_of(const std::string& path, const TableMapping& mapping) {
  auto table = read_table_log(path, mapping);
  if (!table) return table.error().message();
  const auto files = run_files(table->log, "run", {});
  return files ? files->front().content : files.error().message();
}

inline std::string message_of(const std::string& path, const TableMapping& mapping) {
  const auto table = read_table_log(path, mapping);
  return table ? std::string() : table.error().message();
}

}  // namespace octant::io::test
