// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/table.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace octant::app {
namespace {

/// Code points, so that names beyond ASCII do not bend the columns.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

}  // namespace

std::string Table::text() const {
  std::vector<std::size_t> widths(align.size(), 0);
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size() && i < widths.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  std::string out;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size() && i < widths.size(); ++i) {
      const std::string pad(widths[i] - width(row[i]), ' ');
      line += align[i] == 'r' ? pad + row[i] : row[i] + pad;
      line += "  ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

Unit time_unit(double largest_s) {
  if (!(largest_s < 1.0)) return {1.0, "s"};
  if (largest_s >= 1.0e-3) return {1.0e3, "ms"};
  if (largest_s >= 1.0e-7 || largest_s == 0.0) return {1.0e6, "us"};
  return {1.0e9, "ns"};
}

Unit length_unit(double largest_m) { return largest_m < 1.0 ? Unit{1.0e3, "mm"} : Unit{1.0, "m"}; }

std::string length_text(double length_m) {
  const Unit unit = length_unit(std::abs(length_m));
  return fmt::format("{:.3g} {}", unit.per_si * length_m, unit.name);
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string safe = "\"";
  for (const char c : text) safe += c == '"' ? "\"\"" : std::string(1, c);
  return safe + "\"";
}

std::string time_text(double time_s) {
  const Unit unit = time_unit(std::abs(time_s));
  return fmt::format("{:.4g} {}", unit.per_si * time_s, unit.name);
}

}  // namespace octant::app
