// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The tiles against the plain way: same optimum, same covariance.
#include "tests/calib/referee.h"

#include <map>

#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"

namespace octant::test {
namespace referee_test {

void expect_same(const Scenario& scenario, std::uint64_t seed) {
  const World world = must(simulate(scenario, seed));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem);
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  const RefereeResult other = referee(problem, solution);
  ASSERT_TRUE(other.converged);
  EXPECT_NEAR(solution.final_cost, other.cost, 1e-6 * other.cost);
  std::map<std::string, Eigen::Index> index;
  const NameTable names = names_of(world.site);
  for (std::size_t i = 0; i < solution.covariance.parameters.size(); ++i)
    index[parameter_name(solution.covariance.parameters[i], names)] = static_cast<Eigen::Index>(i);
  ASSERT_EQ(solution.covariance.parameters.size(), other.parameters.size());
  for (std::size_t i = 0; i < other.parameters.size(); ++i) {
    ASSERT_TRUE(index.count(other.parameters[i])) << other.parameters[i];
    const Eigen::Index a = index[other.parameters[i]];
    const double sigma =
        std::sqrt(other.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)));
    for (std::size_t j = 0; j <= i; ++j) {
      const auto ii = static_cast<Eigen::Index>(i), jj = static_cast<Eigen::Index>(j);
      const double scale = std::sqrt(other.covariance(ii, ii) * other.covariance(jj, jj));
      // Gauss-Newton matrices of the same state differ by rounding and by how far the two stopped from the
      // optimum.
      EXPECT_NEAR(solution.covariance.matrix(a, index[other.parameters[j]]), other.covariance(ii, jj),
                  1e-3 * scale)
          << other.parameters[i] << " with " << other.parameters[j];
    }
    EXPECT_GT(sigma, 0.0);
  }
  const BeaconErrors ours = beacon_errors(world, solution);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < other.parameters.size(); ++i) {
    const std::string& name = other.parameters[i];
    if (name.rfind("beacon/", 0) != 0 || name.find("_m") == std::string::npos) continue;
    std::size_t b = 0;
    while (name.find("/" + world.truth.beacons[b].name + "/") == std::string::npos) ++b;
    const auto axis = static_cast<Eigen::Index>(name[name.size() - 3] - 'x');
    const double sigma =
        std::sqrt(other.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)));
    EXPECT_NEAR(solution.state.beacon_p_map_m[b][axis], other.values[static_cast<Eigen::Index>(i)],
                1e-2 * sigma)
        << name;
    ++row;
  }
  EXPECT_EQ(row, ours.error.size());
}

Scenario short_hall() {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  return s;
}

TEST(Referee, StationaryEpochs) { expect_same(short_hall(), 1); }

TEST(Referee, CycleOffset) {
  Scenario s = short_hall();
  s.site.timing.clock = Clock::kCycleOffset;
  s.site.timing.delay_per = {};
  s.site.timing.delay_s = s.site.timing.delay_sigma_s = 0.0;
  s.true_delay_s.reset();
  expect_same(s, 2);
}

TEST(Referee, TimeWalkWithAmplitudes) {
  Scenario s = short_hall();
  add_attenuation(s);
  s.log_amplitude = true;
  expect_same(s, 3);
}

TEST(Referee, DelaysPerReceiver) {
  Scenario s = short_hall();
  s.site.timing.delay_per = {.beacon = false, .receiver = true, .site = false};
  expect_same(s, 4);
}

TEST(Referee, MeasuredPoses) {
  Scenario s = short_hall();
  s.log_poses = true;
  expect_same(s, 5);
}

TEST(Referee, DriveWithOdometry) { expect_same(drive_scenario(30.0), 6); }

TEST(Referee, TapedDistances) {
  Scenario s = short_hall();
  s.site.distances = {{BeaconId(1), BeaconId(4), 0.0, 0.003}};
  const auto at = [&](std::size_t b) {
    return Eigen::Vector3d(*s.site.beacons[b].position_m[0], *s.site.beacons[b].position_m[1],
                           *s.site.beacons[b].position_m[2]);
  };
  s.site.distances[0].distance_m = (at(1) - at(4)).norm() + 0.002;
  expect_same(s, 7);
}

}  // namespace referee_test
}  // namespace octant::test
