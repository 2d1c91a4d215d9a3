// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: conditions on the rows of a table.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "io/table/table_layout.h"

namespace octant::io {

/// Index of a column by its name or its number ("#3"); -1 if the table has no such column.
[[nodiscard]] int column_named(const TableLayout& layout, std::string_view name);

class RowFilter {
 public:
  /// Errors: kBadInput: a condition on a column that the table does not have.
  [[nodiscard]] static Result<RowFilter> make(const TableLayout& layout,
                                              const std::vector<RowCondition>& where,
                                              const std::string& path);
  /// True if the cells of a row meet all conditions.
  [[nodiscard]] bool accepts(const std::vector<std::string>& cells, DecimalMark decimal) const;

 private:
  struct Condition {
    std::size_t cell;
    RowCondition condition;
  };
  std::vector<Condition> conditions_;
};

}  // namespace octant::io
