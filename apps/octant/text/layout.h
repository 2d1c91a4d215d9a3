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

inline constexpr std::size_t kTextColumns = 80;  ///< standard width of a terminal

/// Breaks text between words into lines of at most `columns`, each with a newline. Existing newlines are
/// kept.
/// @param indent  number of blanks before all lines except the first
/// @param used    number of columns already used in the first line
[[nodiscard]] std::string paragraph(std::string_view text, std::size_t columns = kTextColumns,
                                    std::size_t indent = 0, std::size_t used = 0);

/// A line of a result: its name in 17 columns, then the text, indented to that column.
[[nodiscard]] std::string named_line(std::string_view name, std::string_view what);

/// Number of columns of a text on a terminal: characters, not bytes.
[[nodiscard]] std::size_t columns_of(std::string_view text);

/// Joins text_of(item) of each item with a separator.
template <class Items, class TextOf>
[[nodiscard]] std::string joined(const Items& items, std::string_view separator, const TextOf& text_of) {
  std::string all;
  for (const auto& item : items) {
    if (&item != &*std::begin(items)) all += separator;
    all += text_of(item);
  }
  return all;
}
/// Counts by reason as text: "3 late, 2 early".
template <class Reasons>
[[nodiscard]] std::string counts_in_words(const Reasons& counts) {
  return joined(counts, ", ", [](const auto& c) { return fmt::format("{} {}", c.second, c.first); });
}

/// Table of text for people.
struct Table {
  std::string align;                           ///< one letter for each column: l or r
  std::vector<std::vector<std::string>> rows;  ///< the first row is the heading
  [[nodiscard]] std::string text() const;
};

using survey::length_text;
using survey::length_unit;
using survey::time_text;
using survey::time_unit;
using survey::Unit;

}  // namespace octant::app
