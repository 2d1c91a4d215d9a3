// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Calibration along a drive in space, by odometry with six degrees of freedom or by measured poses.
#include <gtest/gtest.h>

#include "calib/start/approach.h"
#include "calib/start/mirror_images.h"
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

/// A flat path with measured poses, one receiver, and beacons at unknown positions.
World survey_from_the_surface() {
  Scenario s = drive_scenario(60.0);
  s.site.motion = Motion::kSpatial;
  s.log_poses = true;
  s.site.noise.tof_sigma_s = 1e-4;  // above the errors of the poses
  keep_one_receiver(s.site, {0.2, 0.0, 0.3});
  for (SiteBeacon& b : s.site.beacons) b.sigma_m = {std::nullopt, std::nullopt, std::nullopt};
  return must(simulate(s, 3));
}

// One image alone contradicted the others, and a site was at its mirror image without a warning.
TEST(DriveInSpace, OverAFlatPathAllBeaconsAreReflectedTogether) {
  const World world = survey_from_the_surface();
  const calib::Problem problem = problem_of(world);
  calib::SolveOptions options;
  calib::ProgressMonitor monitor(options);
  calib::Approach found = calib::approach(problem, options, monitor);
  ASSERT_TRUE(found.ok) << found.why_not.message;
  const SharedState before = found.estimate.state();
  ASSERT_TRUE(calib::reflect_beacons(problem, found, found.estimate.sigma_m(problem)));
  const SharedState after = found.estimate.state();
  Pose first;
  ASSERT_TRUE(interpolate_poses(world.run.truth, world.run.arrivals.front().time_s, 10.0, first));
  const double plane_z_m = (first * world.site.receivers[0].position_m).z();
  for (std::size_t b = 0; b < world.site.beacons.size(); ++b)
    // The images are some 4 m below; errors of poses and ranges tilt the plane in which they lie.
    EXPECT_NEAR(after.beacon_p_map_m[b].z() + before.beacon_p_map_m[b].z(), 2 * plane_z_m, 0.5) << b;
  EXPECT_FALSE(calib::reflect_beacons(problem_of(must(simulate(hall_scenario(), 3))), found, 1e-9))
      << "these heights are known";
}

}  // namespace drive_in_space_test
}  // namespace octant::test
