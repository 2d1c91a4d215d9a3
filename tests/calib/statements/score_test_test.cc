// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/score_test.h"

#include <cmath>

#include <gtest/gtest.h>

#include "calib/adjust/adjust.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/statements/adjusted.h"

namespace octant::test {
namespace {

/// A step in all times of flight from a time on, a part of each time of flight until then, and of all, which
/// the speed of sound and the size of the map take up.
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

/// Least cost over all states and parameters once an error of that size is taken back.
double cost_without(std::vector<Trajectory> trajectories, const Adjusted& of, const Errors& errors, int which,
                    double size) {
  for (Trajectory& t : trajectories)
    for (ArrivalObservation& a : t.arrivals)
      a.tof_s -= a.time_s < errors.from_s ? (which == 1 ? size * a.tof_s : 0.0) : (which == 0 ? size : 0.0);
  Eigen::VectorXd x = of.x;
  return calib::adjust(of.problem, of.layout, trajectories, x, {.function_tolerance = 1e-14}).cost;
}

/// A drive of more windows than one, and stops.
class ScoreTest : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(StopsAndDrives, ScoreTest, ::testing::Bool());

// Against the parabola of the cost when everything is adjusted again with the error taken back.
TEST_P(ScoreTest, IsWhatAdjustingAgainGains) {
  const World world = must(simulate(GetParam() ? drive_scenario() : hall_scenario(), 3));
  const calib::Solution solution = solution_of(world);
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged);
  const std::vector<Arrival>& arrivals = world.run.arrivals;
  const Errors errors{arrivals[arrivals.size() / 3].time_s};
  const Adjusted adjusted(world, solution);
  const auto test =
      calib::score_test(solution.trajectories, solution.state, adjusted.parameters(), 3, errors);
  for (int which = 0; which < 2; ++which) {
    const double step = 3.0 / std::sqrt(test.information[which]);
    const double at = cost_without(solution.trajectories, adjusted, errors, which, 0.0),
                 more = cost_without(solution.trajectories, adjusted, errors, which, step),
                 less = cost_without(solution.trajectories, adjusted, errors, which, -step);
    EXPECT_NEAR(test.information[which] * step * step, more + less - 2 * at, 0.01 * (more + less - 2 * at));
    EXPECT_NEAR(test.sigmas(which), 1.5 * (less - more) / (more + less - 2 * at), 0.1);
  }
  EXPECT_EQ(test.sigmas(2), 0.0);
}

// What chance leaves of an error that is not there.
TEST_P(ScoreTest, IsNoLargerThanChance) {
  double squares = 0.0;
  constexpr int kWorlds = 25;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    const World world = must(simulate(GetParam() ? drive_scenario(30.0) : hall_scenario(), seed));
    const calib::Solution solution = solution_of(world);
    const Errors errors{world.run.arrivals[world.run.arrivals.size() / 2].time_s};
    const Adjusted adjusted(world, solution);
    const auto test =
        calib::score_test(solution.trajectories, solution.state, adjusted.parameters(), 3, errors);
    squares += test.sigmas(0) * test.sigmas(0);
    EXPECT_LT(std::abs(test.sigmas(1)), 4.0) << seed;
  }
  EXPECT_LT(squares / kWorlds, 1.8);
  EXPECT_GT(squares / kWorlds, 0.4);  // chi-square of 25, one chance in a thousand
}

TEST(ScoreTests, OfNothingAreZero) {
  const calib::ParameterLayout none;
  const auto test = calib::score_test({}, {}, {none, {}}, 2, Errors{0.0});
  EXPECT_EQ(test.sigmas(0), 0.0);
  EXPECT_EQ(test.size(1), 0.0);
}

}  // namespace
}  // namespace octant::test
