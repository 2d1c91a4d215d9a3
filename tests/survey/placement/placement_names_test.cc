// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include <gtest/gtest.h>

#include "survey/placement/placement.h"

namespace octant::survey {
namespace placement_names_test {

TEST(PlacementNames, AreThoseOfTheCommandLine) {
  EXPECT_EQ(placement_goal("worst"), PlacementGoal::kWorst);
  EXPECT_EQ(placement_goal("p95"), PlacementGoal::kP95);
  EXPECT_EQ(placement_goal("mean"), PlacementGoal::kMean);
  EXPECT_EQ(global_algorithm("none"), GlobalAlgorithm::kNone);
  EXPECT_EQ(global_algorithm("crs2"), GlobalAlgorithm::kCrs2);
  EXPECT_EQ(global_algorithm("direct"), GlobalAlgorithm::kDirect);
  EXPECT_EQ(global_algorithm("isres"), GlobalAlgorithm::kIsres);
  EXPECT_EQ(global_algorithm("esch"), GlobalAlgorithm::kEsch);
  EXPECT_EQ(local_algorithm("none"), LocalAlgorithm::kNone);
  EXPECT_EQ(local_algorithm("bobyqa"), LocalAlgorithm::kBobyqa);
  EXPECT_EQ(local_algorithm("cobyla"), LocalAlgorithm::kCobyla);
  EXPECT_EQ(local_algorithm("sbplx"), LocalAlgorithm::kSbplx);
  EXPECT_EQ(placement_goal("best"), std::nullopt);
  EXPECT_EQ(global_algorithm("sbplx"), std::nullopt) << "a local one";
  EXPECT_EQ(local_algorithm(""), std::nullopt);
}

}  // namespace placement_names_test
}  // namespace octant::survey
