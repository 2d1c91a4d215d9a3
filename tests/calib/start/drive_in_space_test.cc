// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Calibration along a drive in space whose odometry has six degrees of freedom, without measured poses.
#include <gtest/gtest.h>
#include "tests/calib/calib_support.h"
#include "tests/support/statistics.h"

namespace octant::test {
namespace drive_in_space_test {

Scenario flight(double duration_s, double echoes) {
  Scenario s = drive_scenario(duration_s);
  s.site.motion = Motion::kSpatial;
  s.log_odometry = true;
  s.echo_fraction = echoes;
  s.site.tolerance.beacon_m = 0.2;  // all stand at about one height, which is weakly observable
  return s;
}

void expect_honest(const World& world) {
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  EXPECT_LT(worst_beacon_m(world, solution), 0.1);
  const BeaconErrors errors = beacon_errors(world, solution);
  const auto dof = static_cast<double>(errors.error.size());
  EXPECT_LT(errors.nees(), chi2_quantile(1 - 1e-4, dof));
  EXPECT_GT(errors.nees(), chi2_quantile(1e-4, dof));
  EXPECT_NEAR(solution.tof_sigma_s, world.site.noise.tof_sigma_s, 0.1 * world.site.noise.tof_sigma_s);
}

TEST(DriveInSpace, TellsBeaconsByItsOdometry) {
  for (const std::uint64_t seed : {1, 3}) expect_honest(must(simulate(flight(150.0, 0.0), seed)));
}

// Levels of beacons leave tilted images of a path, into which these starts led.
TEST(DriveInSpace, EndsInNoTiltedImage) {
  for (const std::uint64_t seed : {2, 4, 8}) expect_honest(must(simulate(flight(150.0, 0.0), seed)));
}

TEST(DriveInSpace, TellsThemAmongEchoes) {
  for (const std::uint64_t seed : {2, 4, 7, 8}) expect_honest(must(simulate(flight(150.0, 0.05), seed)));
}

}  // namespace drive_in_space_test
}  // namespace octant::test
