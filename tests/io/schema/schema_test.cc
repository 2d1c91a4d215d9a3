// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "io/schema/schema_words.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace {

constexpr const char* kFormats[] = {"site",  "run",  "deployment", "fixes",   "scenario", "scene",
                                    "batch", "live", "survey",     "columns", "topics",   "defaults"};

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

/// Every key below "properties", and every column, has a description and an example, a unit where it is a
/// number or its name states one, and where it may be left out it says what holds then.
void check_words(const nlohmann::json& node, const nlohmann::json& root, const std::string& where,
                 std::size_t& keys) {
  if (!node.is_structured()) return;
  for (const char* list : {"properties", "columns"}) {
    if (!node.is_object() || !node.contains(list) || !node[list].is_object()) continue;
    // A mapping has a key "columns", which is none of a file's list.
    if (std::string_view(list) == "columns" && !node.contains("description")) continue;
    const nlohmann::json required = node.value("required", nlohmann::json::array());
    for (const auto& [name, key] : node[list].items()) {
      ++keys;
      const std::string description = key.value("description", ""), at = where + " " + name;
      EXPECT_FALSE(description.empty()) << at << " has no description";
      EXPECT_TRUE(key.contains("examples") && !key["examples"].empty()) << at << " has no example";
      const std::string unit(unit_of_key(name.substr(0, name.find(','))));
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
    const auto json = nlohmann::json::parse(schema_with_words(format));
    std::size_t keys = 0;
    check_words(json, json, format, keys);
    EXPECT_GT(keys, 4U) << format;
  }
  EXPECT_EQ(unit_of_key("speed_mps"), "m/s");
  EXPECT_EQ(unit_of_key("name"), "");
}

TEST(Schema, APageHasARowForEachKeyAndColumn) {
  const std::string site = schema_page("site"), run = schema_page("run");
  EXPECT_THAT(site,
              testing::HasSubstr("| `timing.delay_sigma_s` | s | 0 | `0.0002` | how far a delay may be"));
  EXPECT_THAT(site, testing::HasSubstr("| `motion` |  | required |"));
  for (const char* row : {"## odometry.csv", "| `dx_m` | m | required |", "| `range0_m, range1_m, ...` | m |",
                          "## truth.csv", "| `qx qy qz qw` |", "| `amplitude_v` | V |  | `1.8` |"})
    EXPECT_THAT(run, testing::HasSubstr(row));
  const std::string deployment = schema_page("deployment"), fixes = schema_page("fixes");
  EXPECT_THAT(deployment, testing::HasSubstr("| `beacons[].delay_sigma_s` | s | required | `4.3e-06` |"));
  EXPECT_THAT(deployment, testing::HasSubstr("| `statistics.redundancy` | 1 | required | `1711` |"));
  EXPECT_THAT(deployment, testing::HasSubstr("a reader refuses one that it does not know"));
  EXPECT_THAT(schema_page("survey"), testing::HasSubstr("| `heading_dop_rad_per_m` | rad/m |  | `8.1` |"));
  EXPECT_THAT(schema_page("columns"),
              testing::HasSubstr("| `columns.distance_m` | m |  | `distance_cm*1e-2` |"));
  EXPECT_THAT(fixes, testing::HasSubstr("| `protection_level_m` | m | required | `0.041` | bound that"));
}

}  // namespace
}  // namespace octant::io
