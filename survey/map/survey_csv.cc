// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/survey_csv.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace octant::survey {
namespace {

std::string csv_quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string safe = "\"";
  for (const char c : text) safe += c == '"' ? "\"\"" : std::string(1, c);
  return safe + "\"";
}

std::string heading(const char* first, const std::vector<FloorMap>& maps) {
  std::string line = first;
  for (const FloorMap& map : maps) line += "," + map.name;
  return line + ",heard\n";
}

void add_values(const Survey& survey, const std::vector<FloorMap>& maps,
                const std::vector<std::vector<std::uint8_t>>& heard_bits, std::size_t i, std::string& csv) {
  for (const FloorMap& map : maps) {
    csv += ',';
    if (map.name == "loss_one_beacon") {
      if (map.values[i] >= 0 && !std::isinf(map.values[i]))
        csv += csv_quoted(survey.model.beacons[static_cast<std::size_t>(map.values[i])].name);
    } else if (!std::isinf(map.values[i])) {
      fmt::format_to(std::back_inserter(csv), "{:.6g}", map.values[i]);
    }
  }
  std::string names;
  for (std::size_t b = 0; b < heard_bits.size(); ++b)
    if (((heard_bits[b][i / 8] >> (i % 8)) & 1) != 0)
      names += (names.empty() ? "" : ";") + survey.model.beacons[b].name;
  csv += "," + csv_quoted(names) + "\n";
}

}  // namespace

std::string survey_csv(const Survey& survey) {
  const FloorGrid& grid = survey.grid;
  std::string csv = heading("x_m,y_m", survey.maps);
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    const Eigen::Vector2d p = grid.centre_m(grid.cells[i]);
    fmt::format_to(std::back_inserter(csv), "{:.10g},{:.10g}", p.x(), p.y());
    add_values(survey, survey.maps, survey.heard_bits, i, csv);
  }
  return csv;
}

std::string routes_csv(const Survey& survey) {
  std::string csv;
  for (const RouteSurvey& route : survey.routes) {
    if (csv.empty()) csv = heading("route,x_m,y_m,heading_rad", route.maps);
    for (std::size_t i = 0; i < route.poses.size(); ++i) {
      fmt::format_to(std::back_inserter(csv), "{},{:.10g},{:.10g},{:.8g}", csv_quoted(route.name),
                     route.poses.x_m[i], route.poses.y_m[i], route.poses.heading_rad[i]);
      add_values(survey, route.maps, route.heard_bits, i, csv);
    }
  }
  return csv;
}

}  // namespace octant::survey
