// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/row_filter.h"

#include <algorithm>
#include <compare>

#include <fmt/format.h>

#include "io/text/text.h"

namespace octant::io {
namespace {

bool meets(std::string_view relation, std::partial_ordering order) {
  if (relation == "=") return order == 0;
  if (relation == "!=") return order != 0;
  if (relation == "<") return order < 0;
  if (relation == "<=") return order <= 0;
  return relation == ">" ? order > 0 : order >= 0;
}

}  // namespace

int column_named(const TableLayout& layout, std::string_view name) {
  const auto named = std::ranges::find(layout.names, name);
  if (named != layout.names.end()) return static_cast<int>(named - layout.names.begin());
  const int number = numbered_column(name);
  return number >= 0 && static_cast<std::size_t>(number) < layout.names.size() ? number : -1;
}

Result<RowFilter> RowFilter::make(const TableLayout& layout, const std::vector<RowCondition>& where,
                                  const std::string& path) {
  RowFilter filter;
  for (const RowCondition& condition : where) {
    const int cell = column_named(layout, condition.column);
    if (cell < 0)
      return fail({.file = path,
                   .line = layout.header_line,
                   .found = fmt::format("the table has no column {} for the condition {}{}{}",
                                        in_quotes(condition.column), condition.column, condition.relation,
                                        condition.value),
                   .expected = fmt::format("columns of the table: {}", listed(layout.names, 20))});
    filter.conditions_.push_back({static_cast<std::size_t>(cell), condition});
  }
  return filter;
}

bool RowFilter::accepts(const std::vector<std::string>& cells, DecimalMark decimal) const {
  return std::ranges::all_of(conditions_, [&](const Condition& c) {
    const std::string cell = c.cell < cells.size() ? cells[c.cell] : "";
    double have = 0.0, want = 0.0;
    const bool wants_number = cell_number(c.condition.value, decimal, want);
    const bool numbers = wants_number && cell_number(cell, decimal, have);
    if (wants_number && !numbers && c.condition.relation.find_first_of("<>") != std::string::npos)
      return false;
    return meets(c.condition.relation,
                 numbers ? have <=> want : lower_case(cell) <=> lower_case(c.condition.value));
  });
}

}  // namespace octant::io
