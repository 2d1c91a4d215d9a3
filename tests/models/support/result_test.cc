// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/result.h"

#include <gtest/gtest.h>

namespace octant::test {
namespace result_test {

TEST(ErrorMessage, SaysWhereWhatAndWhatToDoInOneLine) {
  EXPECT_EQ((Error{.file = "tof.csv", .line = 41, .column = 7, .found = "'x' is not a number"}).message(),
            "tof.csv:41:7: 'x' is not a number");
  EXPECT_EQ((Error{.file = "site.yaml",
                   .found = "beacon 'B9' is not in the site",
                   .expected = "B0 to B7",
                   .advice = "add it"})
                .message(),
            "site.yaml: beacon 'B9' is not in the site; expected B0 to B7; add it");
}

TEST(ErrorMessage, LeavesOutWhatIsNotKnown) {
  EXPECT_EQ((Error{.found = "no memory"}).message(), "no memory");
  EXPECT_EQ((Error{.file = "a", .column = 3, .found = "b"}).message(), "a: b") << "no column without a line";
  EXPECT_EQ((Error{.file = "a", .line = 2, .found = "b", .advice = "c"}).message(), "a:2: b; c");
}

TEST(Fail, IsAResultWithoutAValue) {
  const Result<int> failed = fail({.code = Errc::kOutput, .found = "the disk is full"});
  ASSERT_FALSE(failed.has_value());
  EXPECT_EQ(failed.error().code, Errc::kOutput);
}

}  // namespace result_test
}  // namespace octant::test
