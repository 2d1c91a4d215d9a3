// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/survey_csv.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "survey/geometry/make_survey_model.h"
#include "survey/map/floor_maps.h"
#include "tests/survey/small_scene.h"

namespace octant::survey {
namespace survey_csv_test {

using test::must;
using Table = std::vector<std::vector<std::string>>;

/// RFC 4180, strictly: what any spreadsheet makes of it.
Table parsed(const std::string& csv) {
  Table rows(1, std::vector<std::string>(1));
  bool quoted = false;
  for (std::size_t i = 0; i < csv.size(); ++i) {
    std::string& field = rows.back().back();
    if (quoted && csv[i] == '"' && i + 1 < csv.size() && csv[i + 1] == '"')
      field += csv[i++];
    else if (csv[i] == '"')
      quoted = !quoted;
    else if (!quoted && csv[i] == ',')
      rows.back().emplace_back();
    else if (!quoted && csv[i] == '\n')
      rows.emplace_back(1);
    else
      field += csv[i];
  }
  EXPECT_FALSE(quoted);
  EXPECT_EQ(rows.back(), std::vector<std::string>(1)) << "the last row ends";
  rows.pop_back();
  for (const auto& row : rows) EXPECT_EQ(row.size(), rows[0].size());
  return rows;
}

Survey small_survey() {
  Site site = test::small_site(5);
  site.beacons[1].name = "a, \"b\"";
  Scene scene = test::small_scene();
  scene.cell_m = 1.0;
  scene.acoustics.range_m = 8.0;
  scene.routes[0].name = "way, back";
  return must(run_survey(must(make_survey_model(site, scene)), scene, nullptr));
}

std::size_t column_of(const Table& table, const std::string& name) {
  const auto at = std::find(table[0].begin(), table[0].end(), name);
  EXPECT_NE(at, table[0].end()) << name;
  return static_cast<std::size_t>(at - table[0].begin());
}

/// Numbers of a map as in the table, with the six digits that are written.
void expect_values(const Table& table, const FloorMap& map, const SurveyModel& model) {
  const std::size_t column = column_of(table, map.name);
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    const std::string& text = table[i + 1][column];
    if (map.name == "loss_one_beacon") {
      const bool one = map.values[i] >= 0 && map.values[i] != kNoMapValue;
      EXPECT_EQ(text, one ? model.beacons[static_cast<std::size_t>(map.values[i])].name : "");
    } else if (map.values[i] == kNoMapValue) {
      EXPECT_EQ(text, "") << map.name;
    } else {
      EXPECT_NEAR(std::stod(text), map.values[i], 1e-5 * std::abs(map.values[i])) << map.name;
    }
  }
}

std::string heard_in(const Survey& s, const std::vector<std::vector<std::uint8_t>>& bits, std::size_t i) {
  std::string names;
  for (std::size_t b = 0; b < bits.size(); ++b)
    if ((bits[b][i / 8] >> (i % 8) & 1) != 0) names += (names.empty() ? "" : ";") + s.model.beacons[b].name;
  return names;
}

TEST(SurveyCsv, HasARowForEachCellAndAColumnForEachMap) {
  const Survey s = small_survey();
  const Table table = parsed(survey_csv(s));
  ASSERT_EQ(table.size(), s.grid.cells.size() + 1);
  ASSERT_EQ(table[0].size(), 2 + s.maps.size() + 1);
  for (std::size_t i = 0; i < s.grid.cells.size(); ++i) {
    EXPECT_EQ(std::stod(table[i + 1][0]), s.grid.centre_m(s.grid.cells[i]).x());
    EXPECT_EQ(std::stod(table[i + 1][1]), s.grid.centre_m(s.grid.cells[i]).y());
    EXPECT_EQ(table[i + 1].back(), heard_in(s, s.heard_bits, i));
  }
  for (const FloorMap& map : s.maps) expect_values(table, map, s.model);
  EXPECT_EQ(table[0].back(), "heard");
}

TEST(SurveyCsv, NoFixIsAnEmptyCellAndNoNumber) {
  Survey s = small_survey();
  FloorMap& map = s.maps[0];
  map.values[3] = kNoMapValue;
  EXPECT_EQ(parsed(survey_csv(s))[4][2], "");
  EXPECT_EQ(survey_csv(s).find("inf"), std::string::npos);
}

TEST(SurveyCsv, RoutesFollowEachOtherUnderOneHead) {
  Survey s = small_survey();
  s.routes.push_back(s.routes[0]);
  s.routes[1].name = "back";
  const Table table = parsed(routes_csv(s));
  const std::size_t poses = s.routes[0].poses.size();
  ASSERT_EQ(table.size(), 1 + 2 * poses);
  EXPECT_EQ(table[0][0], "route");
  EXPECT_EQ(table[1][0], "way, back") << "a name with a comma is one field";
  EXPECT_EQ(table[1 + poses][0], "back");
  for (std::size_t i = 0; i < poses; ++i) {
    EXPECT_NEAR(std::stod(table[i + 1][1]), s.routes[0].poses.x_m[i], 1e-8);
    EXPECT_NEAR(std::stod(table[i + 1][2]), s.routes[0].poses.y_m[i], 1e-8);
    EXPECT_NEAR(std::stod(table[i + 1][3]), s.routes[0].poses.heading_rad[i], 1e-7);
    EXPECT_EQ(table[i + 1].back(), heard_in(s, s.routes[0].heard_bits, i));
  }
  for (const FloorMap& map : s.routes[0].maps) expect_values(table, map, s.model);
}

TEST(SurveyCsv, WithoutRoutesThereIsNoTable) {
  Survey s = small_survey();
  s.routes.clear();
  EXPECT_EQ(routes_csv(s), "");
}

}  // namespace survey_csv_test
}  // namespace octant::survey
