// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "survey/geometry/quantity.h"

namespace octant::app {

inline constexpr std::size_t kTextColumns = 80;  ///< of a terminal that nobody has made wider

/// Text broken between words into lines of at most `columns`, each with its newline. Newlines of the text
/// stay.
/// @param indent  blanks before all lines but the first
/// @param used    columns of the first line that hold something already
[[nodiscard]] std::string paragraph(std::string_view text, std::size_t columns = kTextColumns,
                                    std::size_t indent = 0, std::size_t used = 0);

/// A line of a result: its name in 17 columns, then what it says, broken behind them.
[[nodiscard]] std::string named_line(std::string_view name, std::string_view what);

/// Columns that a text takes on a terminal: characters, not bytes.
[[nodiscard]] std::size_t columns_of(std::string_view text);

/// text_of(item) of each, with the separator between them.
template <class Items, class TextOf>
[[nodiscard]] std::string joined(const Items& items, std::string_view separator, const TextOf& text_of) {
  std::string all;
  for (const auto& item : items) {
    if (&item != &*std::begin(items)) all += separator;
    all += text_of(item);
  }
  return all;
}
/// "3 late, 2 early" of counts by reason.
template <class Reasons>
[[nodiscard]] std::string counts_in_words(const Reasons& counts) {
  return joined(counts, ", ", [](const auto& c) { return fmt::format("{} {}", c.second, c.first); });
}

/// Columns of text for people.
struct Table {
  std::string align;                           ///< a letter for each column: l or r
  std::vector<std::vector<std::string>> rows;  ///< the first is the heading
  [[nodiscard]] std::string text() const;
};

using survey::length_text;
using survey::length_unit;
using survey::time_text;
using survey::time_unit;
using survey::Unit;

}  // namespace octant::app
