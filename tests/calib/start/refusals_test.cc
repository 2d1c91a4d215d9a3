// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/refusals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"

namespace octant::test {
namespace refusals_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// One receiver at the origin stops among beacons that are all fixed.
World world_of(std::vector<Eigen::Vector3d> beacons_m, std::uint64_t seed, bool bearings = false) {
  Scenario s = hall_scenario();
  keep_one_receiver(s.site, {0.0, 0.0, 0.3});
  s.site.beacons.resize(beacons_m.size());
  for (std::size_t b = 0; b < beacons_m.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i) {
      s.site.beacons[b].position_m[i] = beacons_m[b][static_cast<Eigen::Index>(i)];
      s.site.beacons[b].sigma_m[i] = 0.0;
    }
  if (bearings) s.bearings = Scenario::Bearings{};
  s.site.noise.bearing_sigma_rad = 0.01;
  s.range_m = 40.0;
  s.path = {};
  s.path.epochs = 60;
  return must(simulate(s, seed));
}

// A few epochs are on one side by chance; a calibration must not depend on them.
TEST(Refusals, HeldBeaconsInALineTellNoSide) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const calib::Solution solution =
        solution_of(world_of({{0.0, 4.0, 2.5}, {5.0, 4.0, 2.5}, {10.0, 4.0, 2.5}}, seed));
    EXPECT_EQ(solution.status, calib::SolveStatus::kUndetermined) << "seed " << seed;
    EXPECT_THAT(solution.message, AllOf(HasSubstr("stand in one line"), HasSubstr("add a beacon beside")));
  }
}

TEST(Refusals, HeldBeaconsBesideALineDo) {
  const calib::Solution solution =
      solution_of(world_of({{0.0, 4.0, 2.5}, {5.0, 4.0, 2.5}, {10.0, 4.0, 2.5}, {7.0, 11.0, 2.5}}, 1));
  EXPECT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
}

TEST(Refusals, BearingsAlonePlaceAVehicle) {
  World world = world_of({{0.0, 0.0, 2.5}, {10.0, 0.0, 2.5}, {5.0, 8.0, 2.5}, {0.0, 8.0, 2.5}}, 1, true);
  world.run.arrivals.clear();
  const calib::Solution solution = solution_of(world);
  EXPECT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
}

TEST(Refusals, TooFewAtOnceAreSaidToBeSo) {
  World world = world_of({{0.0, 0.0, 2.5}, {10.0, 0.0, 2.5}, {5.0, 8.0, 2.5}}, 1);
  std::erase_if(world.run.arrivals, [](const Arrival& a) { return a.epoch % 3 != a.beacon.index(); });
  const calib::Solution solution = solution_of(world);
  EXPECT_EQ(solution.status, calib::SolveStatus::kUndetermined);
  EXPECT_THAT(solution.message,
              AllOf(HasSubstr("hardly anywhere are three beacons"), Not(HasSubstr("in one line"))));
}

}  // namespace refusals_test
}  // namespace octant::test
