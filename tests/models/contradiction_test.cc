// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/contradiction.h"

#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

namespace octant::test {
namespace contradiction_test {

TEST(ContradictionKind, IsFoundAgainByItsName) {
  std::set<std::string> names;
  for (int i = 0; i <= static_cast<int>(ContradictionKind::kLog); ++i) {
    const auto kind = static_cast<ContradictionKind>(i);
    EXPECT_EQ(contradiction_kind(to_string(kind)), kind);
    EXPECT_TRUE(names.insert(to_string(kind)).second);
  }
  EXPECT_EQ(contradiction_kind("no such"), std::nullopt);
}

TEST(ContradictionWords, AreASentenceWithItsSize) {
  Contradiction c{.kind = ContradictionKind::kControlPoint,
                  .subject = "B3",
                  .stated = "at 1 m",
                  .found = "at 2 m",
                  .sigmas = 12.4,
                  .remedy = ""};
  EXPECT_EQ(in_words(c), "Control point B3: stated at 1 m, found at 2 m (12 sigma)");
  c.sigmas = 5.26;
  EXPECT_EQ(in_words(c), "Control point B3: stated at 1 m, found at 2 m (5.3 sigma)");
  c.sigmas = 0.0;
  c.kind = ContradictionKind::kSpeed;
  c.subject = "";
  EXPECT_EQ(in_words(c), "Speed of the medium: stated at 1 m, found at 2 m");
  c.sigmas = INFINITY;
  EXPECT_EQ(in_words(c), "Speed of the medium: stated at 1 m, found at 2 m")
      << "an endless size says nothing";
}

}  // namespace contradiction_test
}  // namespace octant::test
