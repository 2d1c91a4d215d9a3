// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema.h"

#include <nlohmann/json.hpp>

#include "io/schema/schema_words.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace {

TEST(Schema, EachFormatHasOne) {
  for (const char* format : {"site", "run", "deployment", "scenario", "scene", "batch", "live"}) {
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
  for (const char* format : {"site", "run", "deployment", "scenario", "scene", "batch", "live"}) {
    const auto json = nlohmann::json::parse(schema(format));
    check_references(json, json);
  }
}

/// Every key below "properties", and every column, has a description and an example, and a unit where its
/// name states one.
void check_words(const nlohmann::json& node, const std::string& where, std::size_t& keys) {
  if (!node.is_structured()) return;
  for (const char* list : {"properties", "columns"}) {
    if (!node.is_object() || !node.contains(list) || !node[list].is_object()) continue;
    for (const auto& [name, key] : node[list].items()) {
      ++keys;
      EXPECT_FALSE(key.value("description", "").empty()) << where << " " << name << " has no description";
      EXPECT_TRUE(key.contains("examples") && !key["examples"].empty())
          << where << " " << name << " has no example";
      EXPECT_EQ(key.value("x-unit", ""), unit_of_key(name.substr(0, name.find(',')))) << where << " " << name;
    }
  }
  for (const auto& [name, child] : node.items())
    if (name != "if") check_words(child, where + "/" + name, keys);
}

TEST(Schema, EachKeyAndColumnIsExplained) {
  for (const char* format : {"site", "run", "scenario", "scene", "batch"}) {
    const auto json = nlohmann::json::parse(schema_with_words(format));
    std::size_t keys = 0;
    check_words(json, format, keys);
    EXPECT_GT(keys, 6U);
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
}

}  // namespace
}  // namespace octant::io
