// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/score_test.h"

#include <cmath>

#include <gtest/gtest.h>

#include "calib/adjust/adjust.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/statements/adjusted.h"

namespace octant::test {
namespace score_test_test {

/// Errors: a step in all times of flight from a time on; a part of each time of flight until then; and a part
/// of all, which the speed of sound and the size of the map absorb.
struct Errors {
  double from_s;
  bool operator()(const Trajectory& t, const ObservationRow& row, Eigen::RowVectorXd& by) const {
    if (row.kind != RowKind::kTof) return false;
    const ArrivalObservation& a = t.arrivals[row.index];
    by[0] = (a.time_s >= from_s ? 1.0 : 0.0) / a.sigma_s;
    by[1] = a.time_s < from_s ? a.tof_s / a.sigma_s : 0.0;
    by[2] = a.tof_s / a.sigma_s;
    return true;
  }
};

/// Minimal cost over all states and parameters after correction for errors of these sizes.
double cost_without(std::vector<Trajectory> trajectories, const Adjusted& of, const Errors& errors,
                    const Eigen::Vector2d& sizes) {
  for (Trajectory& t : trajectories)
    for (ArrivalObservation& a : t.arrivals)
      a.tof_s -= a.time_s < errors.from_s ? sizes[1] * a.tof_s : sizes[0];
  Eigen::VectorXd x = of.x;
  return calib::adjust(of.problem, of.layout, trajectories, x, {.function_tolerance = 1e-14}).cost;
}

/// A drive of more windows than one, and stops.
class ScoreTest : public ::testing::TestWithParam<bool> {
 protected:
  static World world_of(std::uint64_t seed, double duration_s) {
    return must(simulate(GetParam() ? drive_scenario(duration_s) : hall_scenario(), seed));
  }
};
INSTANTIATE_TEST_SUITE_P(StopsAndDrives, ScoreTest, ::testing::Bool());

// Compared with the parabola of the cost if everything is adjusted again after the correction.
TEST_P(ScoreTest, IsWhatAdjustingAgainGains) {
  const World world = world_of(3, 60.0);
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged);
  const std::vector<Arrival>& arrivals = world.run.arrivals;
  const Errors errors{arrivals[arrivals.size() / 3].time_s};
  const Adjusted adjusted(world, solution);
  const calib::AdjustedParameters parameters = adjusted.parameters();
  const auto test = calib::score_test(solution.trajectories, solution.state, adjusted.layout, 3, errors);
  const auto cost = [&](const Eigen::Vector2d& sizes) {
    return cost_without(solution.trajectories, adjusted, errors, sizes);
  };
  const double at = cost(Eigen::Vector2d::Zero());
  for (int which = 0; which < 2; ++which) {
    const Eigen::Vector3d unit = Eigen::Vector3d::Unit(which);
    const double information = test.information(unit, unit, adjusted.covariance)(0, 0),
                 step = 3.0 / std::sqrt(information);
    const Eigen::Vector2d aside = step * unit.head<2>();
    const double more = cost(aside), less = cost(-aside), bend = more + less - 2 * at;
    EXPECT_NEAR(information * step * step, bend, 0.01 * bend);
    EXPECT_NEAR(test.of_error(which, parameters).sigmas, 1.5 * (less - more) / bend, 0.1);
    EXPECT_NEAR(test.of_error(which, parameters).size[0], step * 0.5 * (less - more) / bend, 0.1 * step);
  }
  EXPECT_EQ(test.of_error(2, parameters).sigmas, 0.0) << "the parameters take it up";
  EXPECT_EQ(test.of_error(2, parameters).size[0], 0.0);
}

// Against an adjustment of times of flight that have the error.
TEST_P(ScoreTest, ParametersFollowAnErrorByItsShift) {
  const World world = world_of(4, 60.0);
  const calib::Solution solution = solution_of(world);
  const std::vector<Arrival>& arrivals = world.run.arrivals;
  const Errors errors{arrivals[arrivals.size() / 2].time_s};
  const Adjusted adjusted(world, solution);
  const auto test = calib::score_test(solution.trajectories, solution.state, adjusted.layout, 3, errors);
  const Eigen::VectorXd shift = test.shift(0, adjusted.covariance);
  constexpr double kError_s = 1e-6;
  const auto adjusted_with = [&](double error_s) {
    std::vector<Trajectory> trajectories = solution.trajectories;
    for (Trajectory& t : trajectories)
      for (ArrivalObservation& a : t.arrivals) a.tof_s += a.time_s < errors.from_s ? 0.0 : error_s;
    Eigen::VectorXd x = adjusted.x;
    (void)calib::adjust(adjusted.problem, adjusted.layout, trajectories, x, {.function_tolerance = 1e-16});
    return x;
  };
  const Eigen::VectorXd moved = (adjusted_with(kError_s) - adjusted_with(-kError_s)) / (2 * kError_s);
  EXPECT_LT((moved - shift).norm(), 0.02 * shift.norm());
}

// With a part of the log the size is the same, though the parameters have followed the error in all of it.
TEST(ScoreTests, OfAPartSayTheSameSize) {
  Scenario scenario = hall_scenario();
  scenario.path.epochs = 900;
  World world = must(simulate(scenario, 5));
  const Errors errors{world.run.arrivals[world.run.arrivals.size() / 2].time_s};
  for (Arrival& a : world.run.arrivals) a.tof_s += a.time_s < errors.from_s ? 0.0 : 1e-5;
  const calib::Solution solution = solution_of(world);
  const Adjusted adjusted(world, solution);
  std::vector<Trajectory> part;
  for (const Trajectory& t : solution.trajectories) part.push_back(some_segments(t, 4));
  const auto tested = [&](const std::vector<Trajectory>& trajectories, double share) {
    return calib::score_test(trajectories, solution.state, adjusted.layout, 3, errors)
        .of_error(0, {adjusted.layout, adjusted.covariance, share});
  };
  const auto whole = tested(solution.trajectories, 1.0), quarter = tested(part, 0.25);
  EXPECT_NEAR(whole.size[0], 1e-5, 1e-6);
  EXPECT_NEAR(quarter.size[0], whole.size[0], 0.2 * whole.size[0]);
  EXPECT_LT(quarter.sigmas, whole.sigmas);
}

// Two errors together, with their estimated sizes.
TEST_P(ScoreTest, OfSeveralIsWhatTheyGainTogether) {
  World world = world_of(4, 60.0);
  const Errors errors{world.run.arrivals[world.run.arrivals.size() / 3].time_s};
  for (Arrival& a : world.run.arrivals) a.tof_s += a.time_s < errors.from_s ? 2e-4 * a.tof_s : 4e-6;
  const calib::Solution solution = solution_of(world);
  const Adjusted adjusted(world, solution);
  const auto test = calib::score_test(solution.trajectories, solution.state, adjusted.layout, 3, errors);
  const auto found = test.of(Eigen::MatrixXd::Identity(3, 2), adjusted.parameters());
  const double gain = cost_without(solution.trajectories, adjusted, errors, Eigen::Vector2d::Zero()) -
                      cost_without(solution.trajectories, adjusted, errors, found.size);
  EXPECT_GT(gain, 1.0);
  EXPECT_NEAR(0.5 * found.sigmas * found.sigmas, gain, 0.05 * gain);
}

// Estimate of an error that is absent, by chance.
TEST_P(ScoreTest, IsNoLargerThanChance) {
  double squares = 0.0;
  constexpr int kWorlds = 25;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    const World world = world_of(seed, 30.0);
    const calib::Solution solution = solution_of(world);
    const Errors errors{world.run.arrivals[world.run.arrivals.size() / 2].time_s};
    const Adjusted adjusted(world, solution);
    const auto test = calib::score_test(solution.trajectories, solution.state, adjusted.layout, 3, errors);
    squares += std::pow(test.of_error(0, adjusted.parameters()).sigmas, 2);
    EXPECT_LT(std::abs(test.of_error(1, adjusted.parameters()).sigmas), 4.0) << seed;
  }
  EXPECT_LT(squares / kWorlds, 2.11);  // chi-square of 25, one chance in a thousand either way
  EXPECT_GT(squares / kWorlds, 0.34);
}

TEST(ScoreTests, OfNothingAreZero) {
  const calib::ParameterLayout none;
  const auto test = calib::score_test({}, {}, none, 2, Errors{0.0});
  EXPECT_EQ(test.of_error(0, {none, {}}).sigmas, 0.0);
  EXPECT_EQ(test.of_error(1, {none, {}}).size[0], 0.0);
}

}  // namespace score_test_test
}  // namespace octant::test
