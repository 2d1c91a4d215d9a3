// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/statistics.h"

#include <cmath>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "models/trajectory/linearise.h"
#include "tests/calib/calib_support.h"

namespace octant::calib {
namespace statistics_test {

constexpr double kRedundancy = 10'000.0;

/// Noise after three steps, starting with an error of `factor`, if a part of the squares comes from
/// observations with fixed noise.
double searched(double factor, double part_of_others) {
  NoiseSearch search;
  for (int round = 0; round < 3; ++round)
    factor *= search
                  .step({0.5 * kRedundancy * (part_of_others + (1 - part_of_others) / (factor * factor)),
                         kRedundancy})
                  .arrivals;
  return factor;
}

TEST(NoiseSearch, OfArrivalsAloneIsDoneInOneStep) {
  NoiseSearch search;
  const double step = search.step({0.5 * kRedundancy * 9.0, kRedundancy}).arrivals;
  EXPECT_DOUBLE_EQ(step, 3.0);
  EXPECT_EQ(search.step({0.5 * kRedundancy * 1.01, kRedundancy}).arrivals, 1.0);
}

// The roots of the squares alone would end at 1.3 to 1.5 for noise ten times too large, at 0.6 for a third.
TEST(NoiseSearch, BesideObservationsWhoseNoiseIsAsStatedEndsAtTheNoiseToo) {
  for (const double factor : {0.1, 0.3, 3.0, 10.0})
    for (const double others : {0.0, 0.2, 0.4, 0.6})
      EXPECT_NEAR(std::log(searched(factor, others)), 0.0, std::log(1.1)) << factor << ", " << others;
}

TEST(NoiseSearch, FewOrNoSquaresTellNothing) {
  NoiseSearch search;
  EXPECT_EQ(search.step({0.5 * 9.0 * 20.0, 20.0}).arrivals, 1.0);
  EXPECT_EQ(search.step({0.0, kRedundancy}).arrivals, 1.0);
}

// Where the squares do not fall with the noise, as of a fault that is no noise, a step stays near the root.
TEST(NoiseSearch, SquaresThatDoNotFallAreNotChasedWithoutEnd) {
  NoiseSearch search;
  double factor = 1.0;
  for (int round = 0; round < 3; ++round)
    factor *= search.step({0.5 * kRedundancy * 1.5, kRedundancy}).arrivals;
  EXPECT_LT(factor, std::pow(std::sqrt(1.5), 13.0));
}

/// Times with a measured pose, each with arrivals at `receivers` receivers from one direction: squares and
/// redundancies of both, for assumed and true variances.
DataSquares moments(double receivers, double arrivals, double poses, double true_arrivals,
                    double true_poses) {
  constexpr double kMoments = 2000.0;
  // Along the direction the poses' misfit to the mean of the arrivals is shared out; the rest is scatter.
  const double taken = poses + arrivals / receivers, is = true_poses + true_arrivals / receivers;
  const double of_poses = poses * is / (taken * taken), of_mean = arrivals / receivers * is / (taken * taken);
  const double scatter = receivers - 1;
  DataSquares data;
  data.poses = {kMoments * of_poses, kMoments * poses / taken};
  data.redundancy = kMoments * (1 + scatter);
  data.cost = 0.5 * kMoments * (of_poses + of_mean + scatter * true_arrivals / arrivals);
  return data;
}

/// Final variances of arrivals and poses, starting from one for both.
std::pair<double, double> variances_found(double receivers, double true_arrivals, double true_poses) {
  NoiseSearch search;
  double arrivals = 1.0, poses = 1.0;
  for (int round = 0; round < 6; ++round) {
    const NoiseFactors factors = search.step(moments(receivers, arrivals, poses, true_arrivals, true_poses));
    if (factors.are_one()) break;
    arrivals *= factors.arrivals * factors.arrivals;
    poses *= factors.poses * factors.poses;
  }
  return {arrivals, poses};
}

// Without a component for the poses, the noise of the arrivals would decrease to zero, because the assumed
// noise of the poses explains more than all squares.
TEST(NoiseSearch, PosesBetterThanStatedLeaveTheArrivalsTheirs) {
  const auto [of_arrivals, of_poses] = variances_found(8, 1.0, 0.01);
  EXPECT_NEAR(of_arrivals, 1.0, 0.15);
  EXPECT_LT(of_poses, 0.2);
}

TEST(NoiseSearch, OdometryBetweenPosesSaysNothingAboutTheArrivals) {
  for (const double odometry : {0.0, 4000.0}) {
    DataSquares data = moments(8, 1.0, 1.0, 1.0, 1.0);
    data.poses.other_squares = odometry;
    data.poses.other_redundancy = 1000.0;
    data.cost += 0.5 * odometry;
    data.redundancy += 1000.0;
    EXPECT_EQ(NoiseSearch().step(data).arrivals, 1.0) << odometry;
  }
}

TEST(NoiseSearch, KeepsTheRatioOfWhatTheDataCannotTellApart) {
  const auto [arrivals, poses] = variances_found(1, 0.1, 0.0);
  EXPECT_NEAR(arrivals, 0.05, 0.01);
  EXPECT_NEAR(poses, 0.05, 0.01);
}

// Errors that receivers share look the same.
TEST(NoiseSearch, PosesThatSeemWorseThanStatedAreLeft) {
  EXPECT_EQ(variances_found(8, 1.0, 9.0).second, 1.0);
  EXPECT_EQ(variances_found(8, 1.0, 1.0), std::pair(1.0, 1.0));
}

// Reference: dense inverse of all states of a segment.
TEST(SquaresOfPoses, HaveTheirShareOfTheRedundancy) {
  Scenario scenario = test::drive_scenario(20.0);
  scenario.log_poses = true;
  scenario.pose_accuracy = {.position_sigma_m = 0.005, .heading_sigma_rad = 0.01};
  scenario.bearings.emplace();
  const World world = test::must(simulate(scenario, 4));
  ASSERT_FALSE(world.run.bearings.empty());
  for (const bool has_odometry : {true, false}) {
    MeasurementLog run = world.run;
    if (!has_odometry) run.odometry.clear();
    const Problem problem = test::must(make_problem(world.site, {run}));
    const SharedState state = prior_state(problem.site);
    Trajectory t = problem.trajectories.front();
    for (Node& node : t.nodes) node.placed = true;
    PoseSquares dense;
    for (const Segment& segment : t.segments) {
      ChainSystem system;
      build_chain_system(t, segment, state, RobustLoss{}, system);
      const auto n = static_cast<Eigen::Index>(t.block_size()),
                 size = n * static_cast<Eigen::Index>(system.D.size());
      Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
      for (Eigen::Index k = 0; k * n < size; ++k) {
        H.block(k * n, k * n, n, n) = system.D[static_cast<std::size_t>(k)];
        if ((k + 1) * n < size) {
          H.block(k * n, (k + 1) * n, n, n) = system.U[static_cast<std::size_t>(k)];
          H.block((k + 1) * n, k * n, n, n) = system.U[static_cast<std::size_t>(k)].transpose();
        }
      }
      const Eigen::MatrixXd P = H.inverse();
      ObservationRow rows[6];
      const auto add = [&](int count, double& squares, double& redundancy) {
        for (int k = 0; k < count; ++k) {
          Eigen::RowVectorXd J = Eigen::RowVectorXd::Zero(size);
          const auto at = n * static_cast<Eigen::Index>(rows[k].node - segment.first_node);
          J.segment(at, n) = rows[k].by_node;
          if (rows[k].has_next) J.segment(at + n, n) = rows[k].by_next;
          squares += rows[k].residual * rows[k].residual;
          redundancy += 1.0 - (J * P).dot(J);
        }
      };
      for (std::size_t i = segment.first_pose; i < segment.last_pose; ++i)
        add(pose_rows(t, i, rows), dense.squares, dense.redundancy);
      for (std::size_t i = segment.first_odometry; i < segment.last_odometry; ++i)
        add(odometry_rows(t, i, rows), dense.other_squares, dense.other_redundancy);
      for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i)
        add(bearing_rows(t, i, state, rows), dense.other_squares, dense.other_redundancy);
    }
    const PoseSquares counted = squares_of_poses(t, state);
    EXPECT_NEAR(counted.squares, dense.squares, 1e-9 * dense.squares);
    EXPECT_NEAR(counted.redundancy, dense.redundancy, 1e-8 * dense.redundancy);
    EXPECT_NEAR(counted.other_squares, dense.other_squares, 1e-9 * dense.other_squares);
    EXPECT_NEAR(counted.other_redundancy, dense.other_redundancy, 1e-8 * dense.other_redundancy);
    EXPECT_GT(dense.redundancy, 10.0);
    EXPECT_EQ(dense.other_redundancy > 10.0, has_odometry);  // bearings of a drive lie between odometry rows
    EXPECT_EQ(t.bearings.empty(), !has_odometry);
  }
}

/// An adjustment of arrivals only whose noise has a wrong factor, like a log that is adjusted again.
struct ScaledLog {
  double factor = 1.0;
  int adjusted = 0, scaled = 0, fails_at = 0;
  std::optional<DataSquares> adjust() {
    if (++adjusted == fails_at) return {};
    return DataSquares{0.5 * kRedundancy / (factor * factor), kRedundancy};
  }
  std::optional<DataSquares> search() {
    return adjust_and_scale_noise([this] { return adjust(); },
                                  [this](const NoiseFactors& by) {
                                    factor *= by.arrivals;
                                    ++scaled;
                                  });
  }
};

TEST(AdjustAndScaleNoise, AdjustsAgainAfterEachStepUntilTheSquaresAgree) {
  ScaledLog as_stated;
  EXPECT_TRUE(as_stated.search());
  EXPECT_EQ(as_stated.adjusted, 1);
  EXPECT_EQ(as_stated.scaled, 0);
  ScaledLog log{.factor = 0.25};
  const auto last = log.search();
  ASSERT_TRUE(last);
  EXPECT_NEAR(log.factor, 1.0, 1e-12);
  EXPECT_NEAR(2 * last->cost, kRedundancy, 1e-6);  // of the adjustment after the step
  EXPECT_EQ(log.adjusted, 2);
  EXPECT_EQ(log.scaled, 1);
}

TEST(AdjustAndScaleNoise, EndsAfterThreeAdjustmentsOrWithOneThatFails) {
  int adjusted = 0, scaled = 0;
  const auto hopeless = [&]() -> std::optional<DataSquares> {
    ++adjusted;
    return DataSquares{2.0 * kRedundancy, kRedundancy};
  };
  EXPECT_TRUE(adjust_and_scale_noise(hopeless, [&](const NoiseFactors&) { ++scaled; }));
  EXPECT_EQ(adjusted, 3);
  EXPECT_EQ(scaled, 3);
  ScaledLog log{.factor = 0.25, .fails_at = 2};
  EXPECT_FALSE(log.search());
  EXPECT_EQ(log.scaled, 1);
}

}  // namespace statistics_test
}  // namespace octant::calib
