// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace octant::app {

/// Columns of text for people.
struct Table {
  std::string align;  ///< a letter for each column: l or r
  std::vector<std::vector<std::string>> rows;  ///< the first is the heading
  [[nodiscard]] std::string text() const;
};

/// A unit in which numbers of a size are read with ease.
struct Unit {
  double per_si = 1.0;  ///< times the SI value
  std::string name;
};
/// s, ms, us or ns.  @param largest_s  largest magnitude of the column
[[nodiscard]] Unit time_unit(double largest_s);
/// m or mm.
[[nodiscard]] Unit length_unit(double largest_m);
/// A length on its own, with its unit: "2.41 mm", "3.2 m".
[[nodiscard]] std::string length_text(double length_m);
/// A field of a CSV row, in quotes where it needs them (RFC 4180).
[[nodiscard]] std::string csv_field(const std::string& text);
/// A time on its own, with its unit.
[[nodiscard]] std::string time_text(double time_s);

}  // namespace octant::app
