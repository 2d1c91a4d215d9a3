// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/profile_csv.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "io/text/csv.h"
#include "io/text/open_file.h"

namespace octant::io {
namespace {

/// Columns of the table. A depth is positive downwards, a height upwards.
struct ProfileColumns {
  int depth, height, speed, temperature, salinity;
  explicit ProfileColumns(CsvReader& csv)
      : depth(csv.find("depth_m")),
        height(depth < 0 ? csv.require("height_m") : csv.find("height_m")),
        speed(csv.find("speed_mps")),
        temperature(speed < 0 ? csv.require("temperature_degC") : csv.find("temperature_degC")),
        salinity(speed < 0 ? csv.require("salinity") : csv.find("salinity")) {}
};

bool read_level(CsvReader& csv, const ProfileColumns& columns, SpeedProfile::Level& level) {
  if (!csv.length(columns.depth < 0 ? columns.height : columns.depth, level.height_m)) return false;
  if (columns.depth >= 0) level.height_m = -level.height_m;
  if (columns.speed >= 0) {
    if (!csv.number(columns.speed, level.speed_mps)) return false;
  } else {
    double temperature_degC = 0.0, salinity = 0.0;
    if (!csv.number(columns.temperature, temperature_degC) || !csv.number(columns.salinity, salinity))
      return false;
    level.speed_mps = sea_water_speed_mps(temperature_degC, salinity, -level.height_m);
  }
  if (level.speed_mps > 0) return true;
  return csv.fail_at(columns.speed, fmt::format("a speed of {} m/s", level.speed_mps),
                     "a speed of sound above zero");
}

/// Returns true if the last level continues in the direction of the previous two.
bool continues(const std::vector<SpeedProfile::Level>& levels) {
  const std::size_t n = levels.size();
  if (n < 2) return true;
  const double step_m = levels[n - 1].height_m - levels[n - 2].height_m;
  return step_m != 0 && (n < 3 || (step_m > 0) == (levels[1].height_m > levels[0].height_m));
}

}  // namespace

Result<SpeedProfile> read_profile(const std::string& path) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  CsvReader csv(map->text(), path);
  const ProfileColumns columns(csv);
  std::vector<SpeedProfile::Level> levels;
  while (csv.next_row()) {
    SpeedProfile::Level level;
    if (!read_level(csv, columns, level)) break;
    levels.push_back(level);
    if (!continues(levels))
      csv.fail_at(columns.depth < 0 ? columns.height : columns.depth, "a depth out of order",
                  "depths that increase from row to row, or decrease");
  }
  if (csv.error()) return fail(*csv.error());
  if (levels.empty())
    return fail({.file = path, .found = "no rows", .expected = "one row or more with a depth and a speed"});
  if (levels.front().height_m > levels.back().height_m) std::ranges::reverse(levels);
  return SpeedProfile(std::move(levels));
}

}  // namespace octant::io
