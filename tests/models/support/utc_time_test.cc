// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/utc_time.h"

#include <gtest/gtest.h>

namespace octant {
namespace utc_time_test {

TEST(UtcTime, ReadsWhatItWrites) {
  for (const std::int64_t s : {0LL, -1LL, 951782400LL, 1767312000LL, 4102444799LL})
    EXPECT_EQ(utc_seconds(utc_text(s)), s);
  EXPECT_EQ(utc_text(951782400), "2000-02-29T00:00:00Z");
  EXPECT_EQ(utc_seconds("2000-02-29"), 951782400);
  EXPECT_EQ(utc_seconds("2000-02-29T01:30:00.25+01:30"), 951782400);
  for (const char* bad : {"", "2001-02-29", "2000-2-29", "yesterday", "2000-02-29T25:00:00Z",
                          "2000-02-29T01:00:00", "2000-02-29Tzz"})
    EXPECT_FALSE(utc_seconds(bad)) << bad;
}

}  // namespace utc_time_test
}  // namespace octant
