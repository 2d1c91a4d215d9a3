// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/name_pattern.h"

#include <gtest/gtest.h>

namespace octant::io {
namespace name_pattern_test {

TEST(NamePattern, PatternsNameBeaconsAndReceivers) {
  const auto names = [](const char* pattern, const char* text) {
    std::map<std::string, std::string, std::less<>> found;
    if (!matches(pattern, text, found)) return std::string("no");
    std::string all;
    for (const auto& [name, value] : found) all += name + "=" + value + " ";
    return all;
  };
  EXPECT_EQ(names("/uwb/{receiver}/{beacon}", "/uwb/front/A1"), "beacon=A1 receiver=front ");
  EXPECT_EQ(names("/uwb/{beacon}", "/uwb/front/A1"), "no") << "a name has no slash";
  EXPECT_EQ(names("/uwb/{beacon}", "/uwb/"), "no");
  EXPECT_EQ(names("anchor_{beacon}_range", "anchor_A_1_range"), "beacon=A_1 ");
  EXPECT_EQ(names("*/{beacon}", "/a/b/c"), "beacon=c ");
  EXPECT_EQ(names("/r", "/r"), "");
  EXPECT_EQ(names("/r", "/rr"), "no");
  EXPECT_EQ(names("********x", std::string(200, 'a').c_str()), "no");
}

}  // namespace name_pattern_test
}  // namespace octant::io
