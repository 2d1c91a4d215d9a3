// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema.h"

#include <nlohmann/json.hpp>

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

}  // namespace
}  // namespace octant::io
