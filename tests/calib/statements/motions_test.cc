// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Stops during which the vehicle moved.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/statements/halls.h"

namespace octant::test {
namespace motions_test {

using testing::HasSubstr;
using testing::IsEmpty;

void expect_a_moved_stop_to_be_named(Ranging ranging) {
  Scenario s = hall_scenario();
  s.site.timing.ranging = ranging;
  s.hearing_half_angle_rad = 3.2;
  s.path.kind = PathKind::kStations;
  s.path.epochs = 40;
  for (int k = 0; k < 40; ++k)
    s.path.stations.emplace_back(3.0 + 0.35 * k, 6.0 + 4.0 * std::sin(0.7 * k), 0.5 * k);
  const World still = must(simulate(s, 14));
  s.path.stations[17].x() += 0.05;
  const World moved = must(simulate(s, 14));
  World world = still;
  std::vector<double> times;
  const std::int64_t epoch = world.run.arrivals.front().epoch + 17;
  for (const Arrival& a : world.run.arrivals)
    if (a.epoch == epoch) times.push_back(a.time_s);
  ASSERT_FALSE(times.empty());
  std::sort(times.begin(), times.end());
  take_over(
      moved, [&](const Arrival& a) { return a.epoch == epoch && a.time_s > times[times.size() / 2]; }, world);
  const calib::Solution solution = solution_of(world);
  EXPECT_THAT(all_in_words(solution), IsEmpty());
  // The beacon and its shift: 50 mm, to a few sigmas of half a stop.
  const std::string before = "stops: stop " + std::to_string(epoch) + " (by ";
  const auto said = std::find_if(solution.warnings.begin(), solution.warnings.end(),
                                 [&](const std::string& w) { return w.find(before) != std::string::npos; });
  ASSERT_NE(said, solution.warnings.end());
  EXPECT_NEAR(std::stod(said->substr(said->find(before) + before.size())), 50.0, 10.0);
  EXPECT_THAT(*said, HasSubstr(" mm), at "));
  EXPECT_THAT(*said, HasSubstr("record it again"));
}

TEST(Agreement, AStopDuringWhichTheVehicleMovedIsNamed) { expect_a_moved_stop_to_be_named(Ranging::kOneWay); }
TEST(Agreement, AStopOfTwoWayRangingDuringWhichTheVehicleMovedIsNamed) {
  expect_a_moved_stop_to_be_named(Ranging::kTwoWay);
}

}  // namespace motions_test
}  // namespace octant::test
