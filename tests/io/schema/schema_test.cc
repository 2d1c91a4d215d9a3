// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema.h"

#include <algorithm>
#include <array>
#include <utility>

#include <nlohmann/json.hpp>

#include "tests/io/io_support.h"

namespace octant::io {
namespace schema_test {

constexpr const char* kFormats[] = {"site", "run",    "deployment", "fixes",  "scenario", "scene",   "batch",
                                    "live", "survey", "columns",    "topics", "cockpit",  "defaults"};

TEST(Schema, EachFormatHasOne) {
  for (const char* format : kFormats) {
    const auto json = nlohmann::json::parse(schema(format), nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << format;
    EXPECT_EQ(json.value("$schema", ""), "https://json-schema.org/draft/2020-12/schema") << format;
    EXPECT_EQ(json.value("type", ""), "object") << format;
  }
  EXPECT_TRUE(schema("sites").empty());
}

/// Every "$ref" leads somewhere.
void check_references(const nlohmann::json& node, const nlohmann::json& root) {
  if (node.is_object() && node.contains("$ref")) {
    const std::string reference = node["$ref"];
    ASSERT_TRUE(reference.starts_with("#")) << reference;
    EXPECT_TRUE(root.contains(nlohmann::json::json_pointer(reference.substr(1)))) << reference;
  }
  if (node.is_structured()) {
    for (const auto& child : node) check_references(child, root);
  }
}

TEST(Schema, ReferencesLeadSomewhere) {
  for (const char* format : kFormats) {
    const auto json = nlohmann::json::parse(schema(format));
    check_references(json, json);
  }
}

bool is_number(const nlohmann::json& key, const nlohmann::json& root) {
  if (key.contains("$ref"))
    return is_number(root.at(nlohmann::json::json_pointer(key["$ref"].get<std::string>().substr(1))), root);
  const nlohmann::json type = key.value("type", nlohmann::json());
  return type == "number" || type == "integer" || type == nlohmann::json({"number", "null"}) ||
         type == nlohmann::json({"integer", "null"});
}

/// Unit in words from the suffix of a key's name: "m/s" for speed_mps; empty without a suffix.
std::string unit_of_key(const std::string& key) {
  using Unit = std::pair<std::string_view, std::string_view>;
  static constexpr std::array<Unit, 30> kUnits = {{{"_m_per_sqrt_m", "m per root of m"},
                                                   {"_m_per_sqrt_km", "m per root of km"},
                                                   {"_gon", "gon"},
                                                   {"_deg", "deg"},
                                                   {"_km", "km"},
                                                   {"_rad_per_m", "rad/m"},
                                                   {"_rad_per_sqrt_m", "rad per root of m"},
                                                   {"_rad_per_s2", "rad/s2"},
                                                   {"_rad_per_s", "rad/s"},
                                                   {"_per_rad", "rad per rad"},
                                                   {"_np_per_m", "Np/m"},
                                                   {"_m_per_m", "m per m"},
                                                   {"_mps_per_year", "m/s per year"},
                                                   {"_m_per_year", "m per year"},
                                                   {"_mps2", "m/s2"},
                                                   {"_mps", "m/s"},
                                                   {"_radps", "rad/s"},
                                                   {"_degC", "degC"},
                                                   {"_dbm", "dBm"},
                                                   {"_ppm", "1e-6"},
                                                   {"_rad", "rad"},
                                                   {"_hz", "Hz"},
                                                   {"_pa", "Pa"},
                                                   {"_m2", "m2"},
                                                   {"_s", "s"},
                                                   {"_m", "m"},
                                                   {"_v", "V"},
                                                   {"_humidity", "fraction, 0 to 1"},
                                                   {"_fraction", "fraction, 0 to 1"},
                                                   {"_relative_sigma", "fraction of the amplitude"}}};
  for (const auto& [ending, unit] : kUnits)
    if (key.ends_with(ending)) return std::string(unit);
  return "";
}

/// Every key below "properties", and every column, has a description and an example, a unit if it is a number
/// or its name has one, and its default if it is optional.
void check_words(const nlohmann::json& node, const nlohmann::json& root, const std::string& where,
                 std::size_t& keys) {
  if (!node.is_structured()) return;
  for (const char* list : {"properties", "columns"}) {
    if (!node.is_object() || !node.contains(list) || !node[list].is_object()) continue;
    // A mapping has a key "columns", which is not a key of a file's list.
    if (std::string_view(list) == "columns" && !node.contains("description")) continue;
    const nlohmann::json required = node.value("required", nlohmann::json::array());
    for (const auto& [name, key] : node[list].items()) {
      ++keys;
      const std::string description = key.value("description", ""), at = where + " " + name;
      EXPECT_FALSE(description.empty()) << at << " has no description";
      EXPECT_TRUE(key.contains("examples") && !key["examples"].empty()) << at << " has no example";
      const std::string unit = unit_of_key(name.substr(0, name.find(',')));
      EXPECT_EQ(key.value("x-unit", ""), unit.empty() && is_number(key, root) ? "1" : unit) << at;
      const bool column = std::string_view(list) == "columns";
      const bool needed = column ? key.value("required", false)
                                 : std::find(required.begin(), required.end(), name) != required.end();
      const bool says_default = key.contains("default") || description.find("eft out") != std::string::npos ||
                                (column && (description.find("else") != std::string::npos ||
                                            description.find("empty") != std::string::npos));
      EXPECT_TRUE(needed || says_default) << at << " does not say what holds where it is left out";
    }
  }
  for (const auto& [name, child] : node.items())
    if (name != "if") check_words(child, root, where + "/" + name, keys);
}

TEST(Schema, EachKeyAndColumnIsExplained) {
  for (const char* format : kFormats) {
    const auto json = nlohmann::json::parse(schema(format));
    std::size_t keys = 0;
    check_words(json, json, format, keys);
    EXPECT_GT(keys, 4U) << format;
  }
}

TEST(Schema, ASiteHoldsTheKeysOfAScene) {
  auto keys = nlohmann::ordered_json::parse(schema("scene"))["properties"];
  EXPECT_EQ(keys.erase("octant_scene"), 1U);
  EXPECT_GT(keys.size(), 10U);
  EXPECT_EQ(nlohmann::ordered_json::parse(schema("site"))["properties"]["scene"]["properties"], keys);
}

TEST(Schema, OfAFileAloneHasItsColumnsAndNoKeys) {
  const auto tof = nlohmann::json::parse(schema_of_file("run", "tof.csv"));
  EXPECT_EQ(tof["title"], "tof.csv: Octant run file (run.yaml)");
  EXPECT_FALSE(tof.contains("properties"));
  EXPECT_EQ(tof["x-files"].size(), 1U);
  EXPECT_EQ(tof["x-files"]["tof.csv"]["columns"]["tof_s"]["x-unit"], "s");
  EXPECT_EQ(schema_of_file("run", "site.yaml"), schema_of_file("run", ""));
}

TEST(Schema, APageHasARowForEachKeyAndColumn) {
  const std::string site = schema_page("site"), run = schema_page("run");
  EXPECT_THAT(
      site, testing::HasSubstr(
                "| `timing.delay_sigma_s` | s | 0 | `0.0002` | standard deviation of the prior of a delay"));
  EXPECT_THAT(site, testing::HasSubstr("| `motion` |  | required |"));
  for (const char* row : {"## odometry.csv", "| `dx_m` | m | required |", "| `range0_m, range1_m, ...` | m |",
                          "## truth.csv", "| `qx qy qz qw` |", "| `amplitude_v` | V |  | `1.8` |"})
    EXPECT_THAT(run, testing::HasSubstr(row));
  const std::string deployment = schema_page("deployment"), fixes = schema_page("fixes");
  EXPECT_THAT(deployment, testing::HasSubstr("| `beacons[].delay_sigma_s` | s | required | `4.3e-06` |"));
  EXPECT_THAT(deployment, testing::HasSubstr("| `statistics.redundancy` | 1 | required | `1711` |"));
  EXPECT_THAT(deployment, testing::HasSubstr("a reader refuses one that it does not know"));
  EXPECT_THAT(schema_page("survey"), testing::HasSubstr("| `heading_dop_rad_per_m` | rad/m |  | `8.1` |"));
  EXPECT_THAT(schema_page("survey"), testing::HasSubstr("| `stations[].sights[].slope_m` | m |"));
  EXPECT_THAT(schema_page("columns"),
              testing::HasSubstr("| `columns.distance_m` | m |  | `distance_cm*1e-2` |"));
  EXPECT_THAT(fixes, testing::HasSubstr("| `protection_level_m` | m | required | `0.041` | bound that"));
}

}  // namespace schema_test
}  // namespace octant::io
