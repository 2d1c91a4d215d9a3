// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/adjust/adjust.h"
#include "calib/adjust/tile.h"
#include "calib/problem/parameters.h"
#include "calib/verdict/datum.h"
#include "tests/calib/adjust/evaluated_tile.h"
#include "tests/calib/calib_support.h"
#include "tests/support/numeric.h"

namespace octant::test {
namespace problem_test {

using testing::HasSubstr;

TEST(MakeProblem, MillisecondsAreNamed) {
  World world = must(simulate(hall_scenario(), 1));
  world.run.path = "run";
  for (Arrival& a : world.run.arrivals) a.tof_s *= 1000;
  const auto problem = calib::make_problem(world.site, {world.run});
  ASSERT_FALSE(problem);
  EXPECT_EQ(problem.error().code, Errc::kBadInput);
  EXPECT_THAT(problem.error().message(), HasSubstr("run/tof.csv"));
  EXPECT_THAT(problem.error().message(), HasSubstr("milliseconds"));
}

TEST(MakeProblem, NothingToCalibrateWithIsAnError) {
  World world = must(simulate(hall_scenario(), 1));
  world.run.arrivals.clear();
  const auto problem = calib::make_problem(world.site, {world.run});
  ASSERT_FALSE(problem);
  EXPECT_THAT(problem.error().message(), HasSubstr("no arrival"));
}

TEST(Layout, VectorAndStateAreInverse) {
  Scenario s = hall_scenario();
  add_attenuation(s);
  s.site.timing.delay_per = {.beacon = true, .receiver = true, .site = false};
  s.site.noise.pair_sigma_s = 1e-6;
  const World world = must(simulate(s, 2));
  const calib::Problem problem = problem_of(world);
  const SharedState prior = prior_state(problem.site);
  const calib::ParameterLayout layout = calib::make_layout(problem, prior);
  Eigen::VectorXd x = layout.vector_of(prior);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += 0.01 * std::sin(static_cast<double>(i));
  const SharedState state = layout.state_of(x);
  EXPECT_LT((layout.vector_of(state) - x).norm(), 1e-12);
  for (std::size_t b = 0; b < 8; ++b)
    if (problem.site.beacons[b].is_control_point())
      EXPECT_EQ(state.beacon_p_map_m[b], prior.beacon_p_map_m[b]);
  // Five free beacons, eight delays of beacons and of receivers, speed, eight receivers, attenuation, pairs.
  EXPECT_EQ(layout.size(), 15 + 8 + 8 + 1 + 24 + 3 + 64);
}

/// Cost as a function of the shared parameters, with the states solved again: the tiles must give its
/// derivative.
void expect_gradient_of_the_solved_cost(bool drive, const RobustLoss& loss) {
  Scenario s = drive ? drive_scenario(10.0) : hall_scenario();
  s.path.epochs = 12;
  const World world = must(simulate(s, 3));
  const calib::Problem problem = problem_of(world);
  calib::Solution solution = calib::solve(problem);
  const calib::ParameterLayout layout = calib::make_layout(problem, solution.state);
  Eigen::VectorXd x = layout.vector_of(solution.state);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += 2e-3 * std::sin(3.0 * static_cast<double>(i));
  std::vector<Trajectory> trajectories = solution.trajectories;
  calib::ReducedSystem system;
  std::vector<calib::Tile> tiles = calib::make_tiles(trajectories, layout);
  ASSERT_EQ(tiles.size(), 1u);
  evaluated(tiles[0], layout.state_of(x), loss, &system);
  tiles[0].commit();
  const auto cost = [&](const Eigen::VectorXd& y) {
    return Eigen::VectorXd::Constant(1, evaluated(tiles[0], layout.state_of(y), loss));
  };
  const Eigen::MatrixXd numeric = numeric_jacobian(cost, x, 1e-5);
  Eigen::VectorXd analytic = Eigen::VectorXd::Zero(x.size());
  for (std::size_t i = 0; i < tiles[0].columns().size(); ++i)
    analytic[tiles[0].columns()[i]] = system.gradient[static_cast<Eigen::Index>(i)];
  // Residuals weigh 3e-3 m; second derivatives of the robust cost limit the central differences.
  EXPECT_LT((numeric.row(0).transpose() - analytic).norm(), 1e-4 * analytic.norm())
      << (drive ? "drive" : "epochs");
}

TEST(Tile, GradientIsThatOfTheSolvedCost) {
  for (const bool drive : {false, true})
    for (const RobustLoss& loss : {RobustLoss{5.0, 5.0}, RobustLoss{}})
      expect_gradient_of_the_solved_cost(drive, loss);
}

TEST(Datum, IsToldInWords) {
  World world = must(simulate(hall_scenario(), 4));
  EXPECT_THAT(calib::datum_of(problem_of(world)).description, HasSubstr("control points (B0, B3, B6)"));
  for (SiteBeacon& b : world.site.beacons) {
    b.position_m = {};
    b.sigma_m = {};
  }
  EXPECT_THAT(calib::datum_of(problem_of(world)).description, HasSubstr("inner constraints"));
}

TEST(MakeDeployment, CarriesTheSolution) {
  const World world = must(simulate(hall_scenario(), 5));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem);
  const Deployment d =
      calib::make_deployment(problem, solution, {"2026-01-01T00:00:00Z", "1", "octant calibrate", {}});
  ASSERT_EQ(d.beacons.size(), 8u);
  EXPECT_EQ(d.beacons[0].status, BeaconStatus::kControlPoint);
  EXPECT_EQ(d.beacons[1].status, BeaconStatus::kCalibrated);
  EXPECT_EQ(d.beacons[1].position_m, solution.state.beacon_p_map_m[1]);
  EXPECT_GT(d.beacons[1].covariance_m2(0, 0), 0.0);
  EXPECT_NEAR(d.beacons[1].covariance_m2(0, 1), d.beacons[1].covariance_m2(1, 0), 1e-18);
  EXPECT_GT(d.speed_sigma_mps, 0.0);
  EXPECT_GE(d.validity_area_m.size(), 3u);
  EXPECT_EQ(d.covariance.parameters.size(), static_cast<std::size_t>(d.covariance.matrix.rows()));
}

}  // namespace problem_test
}  // namespace octant::test
