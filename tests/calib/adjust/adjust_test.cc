// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// End of an adjustment: no later than necessary, and never before the requested accuracy.
#include "calib/adjust/adjust.h"
#include "calib/adjust/information.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "models/trajectory/linearise.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace adjust_test {

struct Off {
  calib::Problem problem;
  calib::ParameterLayout layout;
  std::vector<Trajectory> trajectories;
  Eigen::VectorXd x;
};

/// A solved world, its beacons off again.
Off off_by(double off_m, const Scenario& scenario) {
  const World world = must(simulate(scenario, 4));
  Off off{problem_of(world), {}, {}, {}};
  calib::Solution solution = calib::solve(off.problem, {});
  EXPECT_EQ(solution.status, calib::SolveStatus::kConverged);
  off.trajectories = std::move(solution.trajectories);
  off.layout = calib::make_layout(off.problem, solution.state);
  for (std::size_t b = 0; b < solution.state.beacon_p_map_m.size(); ++b)
    solution.state.beacon_p_map_m[b] += off_m * Eigen::Vector3d(std::sin(2.0 * static_cast<double>(b)),
                                                                std::cos(3.0 * static_cast<double>(b)), 0.5);
  off.x = off.layout.vector_of(solution.state);
  return off;
}

Off hall_off_by(double off_m, int epochs = 300) {
  Scenario scenario = hall_scenario();
  scenario.path.epochs = epochs;
  return off_by(off_m, scenario);
}

calib::AdjustResult adjusted(const Off& off, double tolerance, Eigen::VectorXd& x,
                             std::vector<Trajectory>& trajectories) {
  trajectories = off.trajectories;
  x = off.x;
  calib::AdjustOptions options;
  options.function_tolerance = tolerance;
  return calib::adjust(off.problem, off.layout, trajectories, x, options);
}

TEST(Adjust, StopsWhereTheLastStepIsForetoldAndNotBefore) {
  int with_matrix = 0;
  for (const double off_m : {0.001, 0.003, 0.01, 0.03}) {
    const Off off = hall_off_by(off_m);
    Eigen::VectorXd x, best_x;
    std::vector<Trajectory> there, best_there;
    const double best = adjusted(off, 1e-14, best_x, best_there).cost;
    for (const double tolerance : {1e-5, 1e-6, 1e-8, 1e-10}) {
      SCOPED_TRACE(testing::Message() << off_m << " m, tolerance " << tolerance);
      const calib::AdjustResult result = adjusted(off, tolerance, x, there);
      EXPECT_TRUE(result.converged);
      EXPECT_LE(result.cost - best, tolerance * best);
      if (result.message.find("predicted decrease") == std::string::npos) continue;
      // The matrix is that of the point before the last step, the states are those of x.
      std::vector<Trajectory> solved = there;
      const Eigen::MatrixXd H = calib::information_at(off.problem, off.layout, solved, x).data;
      for (std::size_t k = 0; k < there[0].nodes.size(); ++k)
        EXPECT_LT(
            (there[0].nodes[k].T_map_vehicle.translation_m - solved[0].nodes[k].T_map_vehicle.translation_m)
                .norm(),
            2e-6)
            << k;
      if (!result.data) continue;
      ++with_matrix;
      const Eigen::VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
      EXPECT_LT((scale.asDiagonal() * (result.data->whole(off.layout.size()).H - H) * scale.asDiagonal())
                    .cwiseAbs()
                    .maxCoeff(),
                1e-3);
    }
  }
  EXPECT_GE(with_matrix, 2);
}

TEST(Adjust, OfADriveEndsWhereItsStatesRest) {
  int without_matrix = 0;
  for (const double off_m : {0.003, 0.02, 0.2}) {
    const Off off = off_by(off_m, drive_scenario(120.0));
    Eigen::VectorXd x, best_x;
    std::vector<Trajectory> there, best_there;
    const double best = adjusted(off, 1e-14, best_x, best_there).cost;
    for (const double tolerance : {1e-6, 1e-8}) {
      SCOPED_TRACE(testing::Message() << off_m << " m, tolerance " << tolerance);
      const calib::AdjustResult result = adjusted(off, tolerance, x, there);
      EXPECT_TRUE(result.converged);
      EXPECT_LE(std::abs(result.cost - best), tolerance * best);
      without_matrix += !result.data;  // where rays turned in the last step
      const SharedState state = off.layout.state_of(x);
      std::vector<Trajectory> solved = there;
      double left = 0.0;  // that the states could still gain
      for (const Segment& segment : solved[0].segments)
        left += chain_cost(there[0], segment, state, {}) - solve_states(solved[0], segment, state, {}).cost;
      EXPECT_LE(left, tolerance * best);
    }
  }
  EXPECT_GT(without_matrix, 0);
}

}  // namespace adjust_test
}  // namespace octant::test
