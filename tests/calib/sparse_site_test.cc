// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Sites with too many beacons for a dense matrix of all parameters.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include "calib/adjust/covariance.h"
#include "calib/adjust/information.h"
#include "calib/adjust/sparse_factor.h"
#include "calib/errors/statistics.h"
#include "calib/solution/variances.h"
#include "calib/streamed.h"
#include "calib/verdict/datum.h"
#include "calib/verdict/observability.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/memory_source.h"
#include "tests/calib/thread_team.h"

namespace octant::test {
namespace sparse_site_test {

using ::testing::HasSubstr;

constexpr double kSpacingM = 4.5;

/// A hall with a beacon every 4.5 m, every 25th a control point, the others known to 0.3 m. Stops along its
/// aisles receive the six to eight within 7 m at three receivers.
Scenario wide_hall(int along, int across, int epochs, double sigma_m = 0.3) {
  Scenario s;
  s.site.name = "wide hall";
  s.site.medium = {.model = MediumModel::kCramer1993, .temperature_degC = 21.0};
  s.site.speed_sigma_mps = 2.0;
  s.site.timing.delay_per.beacon = true;
  s.site.timing.delay_sigma_s = 1e-4;
  s.site.noise.tof_sigma_s = 1e-5;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> aside_m(-0.5, 0.5);
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < across; ++j) {
      const std::size_t b = s.site.beacons.size();
      std::string name = "B";
      name += std::to_string(b);
      s.site.beacons.push_back(beacon(name,
                                      {kSpacingM * (i + 0.5) + aside_m(random),
                                       kSpacingM * (j + 0.5) + aside_m(random), 2.75 + 0.5 * aside_m(random)},
                                      b % 25 == 0 ? 0.0 : sigma_m));
    }
  s.hall_m = {along * kSpacingM, across * kSpacingM};
  add_receivers(s.site, {{0.3, 0.0, 0.3}, {-0.15, 0.26, 0.3}, {-0.15, -0.26, 0.3}}, 0.001);
  s.site.tolerance = {.beacon_m = 0.05, .fix_m = 0.05};
  s.range_m = 7.0;
  s.path.kind = s.heldout_path.kind = PathKind::kWaypoints;
  s.path.epochs = epochs;
  s.path.epoch_period_s = s.heldout_path.epoch_period_s = 60.0;  // all beacons fire in turn
  s.heldout_path.epochs = 40;
  for (int j = 0; j < 2 * across; ++j) {
    const double y_m = (j + 0.5) * kSpacingM / 2, near_m = 0.5, far_m = s.hall_m[0] - 0.5;
    for (const double x_m : {j % 2 == 0 ? near_m : far_m, j % 2 == 0 ? far_m : near_m})
      s.path.waypoints_m.emplace_back(x_m, y_m);
  }
  s.heldout_path.waypoints_m = s.path.waypoints_m;
  return s;
}

calib::Solution sparsely(const World& world) {
  calib::SolveOptions options;
  options.dense_limit = 0;
  return solution_of(world, options);
}

/// Compares all results of both methods; they differ only by rounding, of which the covariance has the square
/// root.
void expect_same(const calib::Solution& dense, const calib::Solution& sparse, double place_share = 1e-9) {
  ASSERT_EQ(dense.status, sparse.status);
  ASSERT_TRUE(sparse.covariance.parameters.empty());
  EXPECT_EQ(sparse.marginals.parameters, dense.covariance.parameters);
  for (std::size_t b = 0; b < dense.state.beacon_p_map_m.size(); ++b) {
    EXPECT_LT((dense.state.beacon_p_map_m[b] - sparse.state.beacon_p_map_m[b]).norm(),
              place_share * dense.state.beacon_p_map_m[b].norm())
        << b;
    EXPECT_EQ(dense.beacon_status[b], sparse.beacon_status[b]) << b;
  }
  for (Eigen::Index k = 0; k < sparse.marginals.matrix.outerSize(); ++k)
    for (Eigen::SparseMatrix<double>::InnerIterator it(sparse.marginals.matrix, k); it; ++it) {
      const double scale = std::sqrt(dense.covariance.matrix(it.row(), it.row()) *
                                     dense.covariance.matrix(it.col(), it.col()));
      EXPECT_NEAR(it.value(), dense.covariance.matrix(it.row(), it.col()), 1e-6 * scale) << "column " << k;
    }
  ASSERT_EQ(dense.weak.size(), sparse.weak.size());
  for (std::size_t i = 0; i < dense.weak.size(); ++i) {
    EXPECT_EQ(dense.weak[i].description, sparse.weak[i].description);
    EXPECT_NEAR(dense.weak[i].sigma_m, sparse.weak[i].sigma_m, 1e-6 * dense.weak[i].sigma_m);
  }
}

TEST(SparseFactor, InverseIsThatOfTheDenseMatrixWhereItIsTold) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> column(0, 59);
  std::normal_distribution<double> value;
  Eigen::SparseMatrix<double> J(300, 60);
  for (int row = 0; row < 300; ++row)
    for (int k = 0; k < 3; ++k) J.coeffRef(row, column(random)) += value(random);
  Eigen::SparseMatrix<double> N = J.transpose() * J;
  N.makeCompressed();
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(N).inverse();
  const auto factor = calib::SparseFactor::of(N);
  ASSERT_NE(factor, nullptr);
  const double rounding = 1e-12 * inverse.diagonal().maxCoeff();
  for (Eigen::Index j = 0; j < N.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator it(N, j); it; ++it) {
      ASSERT_TRUE(factor->inverse(it.row(), it.col()).has_value());
      EXPECT_NEAR(*factor->inverse(it.row(), it.col()), inverse(it.row(), it.col()), rounding);
    }
  EXPECT_LT((factor->solve(Eigen::MatrixXd::Identity(60, 60)) - inverse).norm(), 60 * rounding);
  N.coeffRef(3, 3) = -1.0;
  EXPECT_EQ(calib::SparseFactor::of(N), nullptr);
}

TEST(SparseSite, IsSolvedAsADenseOne) {
  const World world = must(simulate(wide_hall(6, 5, 300), 11));
  const calib::Solution dense = solution_of(world), sparse = sparsely(world);
  ASSERT_EQ(dense.status, calib::SolveStatus::kConverged) << dense.message;
  expect_same(dense, sparse);
  const calib::Reliability &a = dense.reliability, &b = sparse.reliability;
  ASSERT_TRUE(a.ok && b.ok);
  ASSERT_EQ(a.arrivals.size(), b.arrivals.size());
  EXPECT_NEAR(a.redundancy_sum, b.redundancy_sum, 1e-6 * a.redundancy_sum);
  for (std::size_t i = 0; i < a.arrivals.size(); ++i)
    EXPECT_NEAR(a.arrivals[i].w, b.arrivals[i].w, 1e-5) << i;
  for (std::size_t i = 0; i < a.beacons.size(); ++i) {
    ASSERT_TRUE(a.beacons[i].lateness_mdb_s && b.beacons[i].lateness_mdb_s);
    EXPECT_NEAR(*a.beacons[i].lateness_mdb_s, *b.beacons[i].lateness_mdb_s,
                1e-5 * *a.beacons[i].lateness_mdb_s);
    EXPECT_NEAR(*a.beacons[i].lateness_influence_m, *b.beacons[i].lateness_influence_m,
                1e-4 * *a.beacons[i].lateness_influence_m);
    // Only for the beacons received at the stop, which an arrival moves most.
    EXPECT_LE(*b.beacons[i].influence_worst_m, *a.beacons[i].influence_worst_m * (1 + 1e-6));
    EXPECT_GE(*b.beacons[i].influence_worst_m, 0.9 * *a.beacons[i].influence_worst_m);
  }
}

/// Read some hundred stops or states at a time.
calib::Solution streamed(const World& world, int dense_limit, const calib::Ranks* ranks = nullptr) {
  calib::SolveOptions options;
  options.dense_limit = dense_limit;
  options.ranks = ranks;
  std::vector<MeasurementLog> runs = {world.run};
  if (!world.heldout.arrivals.empty() && world.heldout.has_epochs != world.run.has_epochs)
    runs.push_back(world.heldout);  // stops beside a drive
  MemorySource source(runs, 300);
  return must(calib::solve_streamed(world.site, source, options, std::size_t{8} << 20U)).solution;
}

void expect_same_streamed(const World& world) {
  const calib::Solution dense = streamed(world, calib::kDenseLimit), sparse = streamed(world, 0);
  ASSERT_EQ(dense.status, calib::SolveStatus::kConverged) << dense.message;
  expect_same(dense, sparse, 1e-8);
  EXPECT_EQ(sparse.statistics.rejected, dense.statistics.rejected);
  EXPECT_EQ(sparse.statistics.redundancy, dense.statistics.redundancy);
  EXPECT_NEAR(sparse.reliability.redundancy_sum, dense.reliability.redundancy_sum,
              1e-5 * dense.reliability.redundancy_sum);
  std::vector<calib::Solution> answers(2);
  for_each_rank(2, [&](const calib::Ranks& rank) {
    answers[static_cast<std::size_t>(rank.index())] = streamed(world, 0, &rank);
  });
  for (const calib::Solution& answer : answers) expect_same(dense, answer, 1e-8);
}

// The stated least memory of streaming covers the sums; a drive connects all beacons.
TEST(SparseSite, SumsAreReckonedWith) {
  const MeasurementLog run;
  const auto least = [&](const Scenario& scenario, std::size_t odometry_rows) {
    return calib::least_memory_streamed(scenario.site, {&run}, 1000, odometry_rows);
  };
  const Scenario small = wide_hall(4, 4, 1), wide = wide_hall(20, 20, 1);
  const std::size_t parameters = 20 * 20 * 4;
  EXPECT_GT(least(wide, 0), least(small, 0) + sizeof(double) * parameters * calib::kDenseLimit);
  EXPECT_GT(least(wide, 10), least(small, 10) + sizeof(double) * parameters * parameters);
}

TEST(SparseSite, IsReadInChunksAsADenseOne) {
  expect_same_streamed(must(simulate(wide_hall(9, 8, 3000), 15)));
}

TEST(SparseSite, IsDrivenThroughInPieces) {
  Scenario s = drive_scenario(500.0);
  s.echo_fraction = 0.01;
  expect_same_streamed(must(simulate(s, 16)));
  s = drive_scenario(300.0);
  s.heldout_path.kind = PathKind::kStops;
  s.heldout_path.epochs = 1500;
  const World both = must(simulate(s, 17));
  ASSERT_TRUE(both.heldout.has_epochs);
  expect_same_streamed(both);
}

TEST(SparseSite, FreeNetworkHasTheSameCovarianceInBothWays) {
  const World world = must(simulate(wide_hall(4, 4, 200), 12));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem);
  calib::Problem all_free = problem;
  for (SiteBeacon& b : all_free.site.beacons) b.sigma_m.fill(1e4);
  const calib::ParameterLayout layout = calib::make_layout(all_free, solution.state);
  const Eigen::VectorXd x = layout.vector_of(solution.state);
  std::vector<Trajectory> trajectories = solution.trajectories;
  const calib::Information information = calib::information_at(all_free, layout, trajectories, x);
  const Eigen::SparseMatrix<double> N = calib::sparse_information_at(all_free, layout, trajectories, x);
  EXPECT_LT((Eigen::MatrixXd(N) - information.data - information.prior).norm(),
            1e-12 * information.data.norm());
  const Eigen::MatrixXd datum = calib::free_datum(all_free, layout, solution.state, N);
  ASSERT_EQ(datum.cols(), 3);
  const calib::Covariance dense(Eigen::MatrixXd(N), datum), sparse(N, datum);
  ASSERT_EQ(sparse.matrix(), nullptr);
  // The freedoms cost digits in either way: the map's place is unknown by 1e4 m, its shape known to 1e-3 m.
  for (int i = 0; i < layout.size(); ++i)
    for (int j = 0; j <= i; ++j)
      EXPECT_NEAR(sparse(i, j), dense(i, j), 1e-5 * std::sqrt(dense(i, i) * dense(j, j))) << i << " " << j;
}

TEST(SparseSite, RefusesWhatADenseOneRefuses) {
  World world = must(simulate(wide_hall(4, 4, 60), 13));
  world.site.tolerance.beacon_m = 1e-3;
  const calib::Solution dense = solution_of(world), sparse = sparsely(world);
  ASSERT_EQ(dense.status, calib::SolveStatus::kUndetermined);
  ASSERT_EQ(sparse.status, calib::SolveStatus::kUndetermined);
  EXPECT_EQ(dense.undetermined, sparse.undetermined);
}

TEST(SparseSite, BeaconsBeyondTheDenseLimitAreAsGoodAsTheirCovarianceSays) {
  const World world = must(simulate(wide_hall(14, 12, 1200), 14));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem, {.threads = 2});
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  ASSERT_GT(solution.marginals.parameters.size(), static_cast<std::size_t>(calib::kDenseLimit));
  ASSERT_TRUE(solution.covariance.parameters.empty());
  const calib::ParameterLayout layout = calib::make_layout(problem, solution.state);
  std::vector<Trajectory> trajectories = solution.trajectories;
  const Eigen::VectorXd x = layout.vector_of(solution.state);
  const Eigen::SparseMatrix<double> N = calib::sparse_information_at(problem, layout, trajectories, x);
  // All errors at once: e' N e against chi-square, which one seed in ten thousand would miss by chance.
  const Eigen::VectorXd error = x - layout.vector_of(shared_state(world.truth));
  const double nees = error.dot(N * error);
  EXPECT_GT(calib::chi_square_p(nees, static_cast<double>(layout.size())), 1e-4)
      << nees << " of " << layout.size();
  // The marginals against Eigen's own factor, a method without a selected inverse.
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(N);
  const calib::Variances variances(solution);
  for (const int column :
       {7, 320, layout.column_of(parameters::beacon_delay(85)), layout.speed[0], layout.receiver[2][1]}) {
    const calib::Parameter& p = layout.parameters[static_cast<std::size_t>(column)];
    const double variance = ldlt.solve(Eigen::VectorXd::Unit(layout.size(), column))[column];
    EXPECT_NEAR(variances.sigma(p.id), p.si_per_unit * std::sqrt(variance),
                1e-6 * p.si_per_unit * std::sqrt(variance))
        << "column " << column;
  }
  const Deployment d = calib::make_deployment(problem, solution, {});
  EXPECT_TRUE(d.covariance.parameters.empty());
  for (const DeploymentBeacon& b : d.beacons)
    if (b.status == BeaconStatus::kCalibrated) {
      EXPECT_GT(b.covariance_m2.diagonal().minCoeff(), 0.0) << b.name;
      EXPECT_GT(b.delay_sigma_s, 0.0) << b.name;
    }
  EXPECT_GT(d.speed_sigma_mps, 0.0);
  EXPECT_THAT(solution.warnings, ::testing::Contains(HasSubstr("joint covariance")));
}

}  // namespace sparse_site_test
}  // namespace octant::test
