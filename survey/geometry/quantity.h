// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace octant::survey {

/// A unit in which numbers of a size are easy to read.
struct Unit {
  double per_si = 1.0;  ///< times the SI value
  std::string name;     ///< in ASCII, for terminals and files: "us"
  std::string symbol;   ///< as printed: "µs"
};
/// A number with three significant digits, and all digits before the point.
[[nodiscard]] std::string three_digits(double value);
/// s, ms, us or ns.  @param largest_s  largest magnitude of the column
[[nodiscard]] Unit time_unit(double largest_s);
/// m or mm.
[[nodiscard]] Unit length_unit(double largest_m);
/// A length on its own, with its unit: "2.41 mm", "3.2 m".
[[nodiscard]] std::string length_text(double length_m);
/// A time on its own, with its unit, in ASCII.
[[nodiscard]] std::string time_text(double time_s);
/// A value with its unit as people read it: millimetres for short lengths, "3.2 m", "1.4".
[[nodiscard]] std::string figure_text(double value, const std::string& unit);
/// A share: "99.5 %".
[[nodiscard]] std::string percent_text(double fraction);
/// A time on its own, as printed: "12.3 µs".
[[nodiscard]] std::string time_symbol_text(double time_s);

}  // namespace octant::survey
