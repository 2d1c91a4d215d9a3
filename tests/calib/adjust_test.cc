// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Where an adjustment stops: no later than it has to, and never before what it was asked for is there.
#include "calib/adjust.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"

namespace octant::test {
namespace {

struct Off {
  calib::Problem problem;
  calib::ParameterLayout layout;
  std::vector<Trajectory> trajectories;
  Eigen::VectorXd x;
};

/// A solved hall, its beacons off again.
Off hall_off_by(double off_m, int epochs = 300) {
  Scenario scenario = hall_scenario();
  scenario.path.epochs = epochs;
  const World world = must(simulate(scenario, 4));
  Off off{problem_of(world), {}, {}, {}};
  calib::Solution solution = calib::solve(off.problem, {});
  EXPECT_EQ(solution.status, calib::SolveStatus::kConverged);
  off.trajectories = std::move(solution.trajectories);
  off.layout = calib::make_layout(off.problem, solution.state, std::vector<bool>(world.site.beacons.size(), false));
  for (std::size_t b = 0; b < solution.state.beacon_p_map_m.size(); ++b)
    solution.state.beacon_p_map_m[b] +=
        off_m * Eigen::Vector3d(std::sin(2.0 * static_cast<double>(b)), std::cos(3.0 * static_cast<double>(b)), 0.5);
  off.x = off.layout.vector_of(solution.state);
  return off;
}

calib::AdjustResult adjusted(const Off& off, double tolerance, Eigen::VectorXd& x, std::vector<Trajectory>& trajectories) {
  trajectories = off.trajectories;
  x = off.x;
  calib::AdjustOptions options;
  options.function_tolerance = tolerance;
  return calib::adjust(off.problem, off.layout, trajectories, x, options);
}

TEST(Adjust, StopsWhereTheLastStepIsForetoldAndNotBefore) {
  int foretold = 0;
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
      if (result.message.find("foretold") == std::string::npos) continue;
      ++foretold;
      // The matrix is that of the point before the last step, the states are those of x.
      std::vector<Trajectory> settled = there;
      const Eigen::MatrixXd H = calib::information_at(off.problem, off.layout, settled, x).data;
      ASSERT_TRUE(result.data_information);
      const Eigen::VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
      EXPECT_LT((scale.asDiagonal() * (*result.data_information - H) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-3);
      for (std::size_t k = 0; k < there[0].nodes.size(); ++k)
        EXPECT_LT((there[0].nodes[k].T_map_vehicle.translation_m - settled[0].nodes[k].T_map_vehicle.translation_m).norm(), 2e-6)
            << k;
    }
  }
  EXPECT_GE(foretold, 2);
}

/// What another matrix than the true one leads to, from two centimetres off.
struct Led {
  double above_best = 0.0, matrix_off = INFINITY;
  std::string message;
};

Led led_by(const Off& off, const Eigen::MatrixXd& matrix, bool wanted, double tolerance = 1e-6) {
  Eigen::VectorXd x = off.x, best_x;
  std::vector<Trajectory> there = off.trajectories, best_there;
  const double best = adjusted(off, 1e-14, best_x, best_there).cost;
  calib::AdjustOptions options;
  options.function_tolerance = tolerance;
  options.borrowed_matrix = matrix;
  options.matrix_wanted = wanted;
  const calib::AdjustResult result = calib::adjust(off.problem, off.layout, there, x, options);
  EXPECT_TRUE(result.converged);
  Led led{result.cost / best - 1.0, INFINITY, result.message};
  // The cost that is told is that of x and of the states that are left.
  calib::Information at_x = calib::information_at(off.problem, off.layout, there, x);
  EXPECT_NEAR(result.cost, at_x.data_cost + calib::prior_cost(off.problem, off.layout, x), 1e-7 * best);
  if (!result.data_information) return led;
  const Eigen::VectorXd scale = at_x.data.diagonal().cwiseSqrt().cwiseInverse();
  led.matrix_off = (scale.asDiagonal() * (*result.data_information - at_x.data) * scale.asDiagonal()).cwiseAbs().maxCoeff();
  return led;
}

TEST(Adjust, ABorrowedMatrixLeadsToTheSameOptimum) {
  constexpr std::size_t kEvery = 8;
  const Off off = hall_off_by(0.02, 1600);
  Off part = off;
  part.trajectories = {some_segments(off.trajectories[0], kEvery)};
  Eigen::VectorXd x;
  std::vector<Trajectory> there;
  const Eigen::MatrixXd matrix = *adjusted(part, 1e-6, x, there).data_information * static_cast<double>(kEvery);
  Off from_part = off;
  from_part.x = x;
  for (const Off* from : {&off, static_cast<const Off*>(&from_part)})
    for (const bool wanted : {false, true}) {
      const Led led = led_by(*from, matrix, wanted);
      EXPECT_LT(led.above_best, 1e-6) << wanted;
      if (wanted) {
        EXPECT_LT(led.matrix_off, 1e-3);
      }
    }
  int led_all_the_way = 0;
  for (const double tolerance : {1e-5, 1e-6, 1e-7, 1e-8}) {
    const Led led = led_by(from_part, matrix, false, tolerance);
    EXPECT_LT(led.above_best, tolerance);
    led_all_the_way += std::isinf(led.matrix_off) ? 1 : 0;
  }
  EXPECT_GE(led_all_the_way, 1) << "all steps needed a matrix of their own";
}

TEST(Adjust, AMatrixOfSomethingElseDoesNoHarm) {
  const Off off = hall_off_by(0.02, 400);
  const Eigen::Index n = off.layout.size();
  Eigen::VectorXd x;
  std::vector<Trajectory> there;
  const Eigen::MatrixXd right = *adjusted(off, 1e-6, x, there).data_information;
  for (const Eigen::MatrixXd& matrix :
       {Eigen::MatrixXd(100.0 * right), Eigen::MatrixXd(0.01 * right), Eigen::MatrixXd(Eigen::MatrixXd::Zero(n, n)),
        Eigen::MatrixXd(Eigen::MatrixXd::Identity(n, n)), Eigen::MatrixXd(1e12 * Eigen::MatrixXd::Identity(n, n))})
    for (const bool wanted : {false, true}) {
      const Led led = led_by(off, matrix, wanted);
      EXPECT_LT(led.above_best, 1e-6) << matrix(0, 0) << " " << led.message;
    }
}

}  // namespace
}  // namespace octant::test
