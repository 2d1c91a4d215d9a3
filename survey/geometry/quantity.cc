// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/quantity.h"

#include <cmath>

#include <fmt/format.h>

namespace octant::survey {

Unit time_unit(double largest_s) {
  if (!(largest_s < 1.0)) return {1.0, "s", "s"};
  if (largest_s >= 1.0e-3) return {1.0e3, "ms", "ms"};
  if (largest_s >= 1.0e-7 || largest_s == 0.0) return {1.0e6, "us", "µs"};
  return {1.0e9, "ns", "ns"};
}

Unit length_unit(double largest_m) { return largest_m < 1.0 ? Unit{1.0e3, "mm", "mm"} : Unit{1.0, "m", "m"}; }

std::string three_digits(double value) {
  // From here on {:.3g} writes 1e+03.
  return std::abs(value) >= 999.5 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

std::string length_text(double length_m) {
  const double size_m = std::abs(length_m);
  // 999.5 mm and more round to 1000 mm with three digits.
  const Unit unit = length_unit(size_m >= 0.9995 && size_m < 1.0 ? 1.0 : size_m);
  return three_digits(unit.per_si * length_m) + " " + unit.name;
}

std::string time_text(double time_s) {
  const Unit unit = time_unit(std::abs(time_s));
  return fmt::format("{:.4g} {}", unit.per_si * time_s, unit.name);
}

std::string figure_text(double value, const std::string& unit) {
  if (std::isinf(value)) return "no fix";
  if (unit == "m") return value < 0.0995 ? three_digits(1e3 * value) + " mm" : three_digits(value) + " m";
  return unit.empty() ? three_digits(value) : three_digits(value) + " " + unit;
}

std::string percent_text(double fraction) { return fmt::format("{:.1f} %", 100 * fraction); }

std::string time_symbol_text(double time_s) {
  const Unit unit = time_unit(std::abs(time_s));
  return fmt::format("{:.4g} {}", unit.per_si * time_s, unit.symbol);
}

}  // namespace octant::survey
