// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include <gtest/gtest.h>

#include "survey/placement/placement.h"

namespace octant::survey {
namespace {

TEST(PlacementNames, AreReadAsTheyAreWritten) {
  for (const PlacementGoal goal : {PlacementGoal::kWorst, PlacementGoal::kP95, PlacementGoal::kMean})
    EXPECT_EQ(placement_goal(to_string(goal)), goal);
  for (const GlobalAlgorithm a : {GlobalAlgorithm::kNone, GlobalAlgorithm::kCrs2, GlobalAlgorithm::kDirect,
                                  GlobalAlgorithm::kIsres, GlobalAlgorithm::kEsch})
    EXPECT_EQ(global_algorithm(to_string(a)), a);
  for (const LocalAlgorithm a :
       {LocalAlgorithm::kNone, LocalAlgorithm::kBobyqa, LocalAlgorithm::kCobyla, LocalAlgorithm::kSbplx})
    EXPECT_EQ(local_algorithm(to_string(a)), a);
  EXPECT_EQ(placement_goal("best"), std::nullopt);
  EXPECT_EQ(global_algorithm("sbplx"), std::nullopt) << "a local one";
  EXPECT_EQ(local_algorithm(""), std::nullopt);
}

}  // namespace
}  // namespace octant::survey
