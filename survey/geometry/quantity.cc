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

std::string length_text(double length_m) {
  const Unit unit = length_unit(std::abs(length_m));
  return fmt::format("{:.3g} {}", unit.per_si * length_m, unit.name);
}

std::string time_text(double time_s) {
  const Unit unit = time_unit(std::abs(time_s));
  return fmt::format("{:.4g} {}", unit.per_si * time_s, unit.name);
}

std::string time_symbol_text(double time_s) {
  const Unit unit = time_unit(std::abs(time_s));
  return fmt::format("{:.4g} {}", unit.per_si * time_s, unit.symbol);
}

}  // namespace octant::survey
