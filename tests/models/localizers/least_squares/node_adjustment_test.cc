// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The adjustment of one node against dense generalised least squares with numeric derivatives.
#include "models/localizers/least_squares/node_adjustment.h"

#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/localizers/common/trajectory_model.h"
#include "tests/models/localizers/hall.h"

namespace octant {
namespace node_adjustment_test {

using test::hall;
using test::hear;
using test::random_pose;
using test::with_octagon;

/// A stop near its truth, all arrivals in use.
struct Stop {
  Deployment d = with_octagon(hall());
  EpochFixModel model = epoch_fix_model(d);
  Trajectory t;
  Pose truth;
  explicit Stop(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    truth = random_pose(random);
    set_epoch(t, hear(d, truth, {.noise_s = 1e-5}, random), {}, trajectory_model(d));
    t.nodes[0].T_map_vehicle = truth * Pose::planar(0.03, -0.02, 0.04);
    t.nodes[0].placed = true;
  }
  NodeAdjustment adjust(double uncertainty_m) {
    return adjust_node(t, t.segments[0], model.state, uncertainty_m);
  }

  /// Residuals in metres at the node moved in the map's axes and about its own.
  [[nodiscard]] Eigen::VectorXd residuals_m(const Eigen::Vector3d& move) const {
    const Pose& at = t.nodes[0].T_map_vehicle;
    const Pose T = Pose::planar(at.translation_m.x() + move.x(), at.translation_m.y() + move.y(),
                                at.heading_rad() + move.z());
    Eigen::VectorXd r(static_cast<Eigen::Index>(t.arrivals.size()));
    for (std::size_t i = 0; i < t.arrivals.size(); ++i) {
      const ArrivalObservation& a = t.arrivals[i];
      const double distance =
          (T * d.receivers[a.receiver.index()].position_m - d.beacons[a.beacon.index()].position_m).norm();
      const double c = a.model_speed_mps;
      r[static_cast<Eigen::Index>(i)] = c * (a.tof_s - model.state.delay_s(a.beacon, a.receiver)) - distance;
    }
    return r;
  }
  /// Covariance of the ranges: noise, and the common error of a beacon.
  [[nodiscard]] Eigen::MatrixXd noise_m2(double uncertainty_m) const {
    const auto n = static_cast<Eigen::Index>(t.arrivals.size());
    Eigen::MatrixXd V = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) {
        const auto &a = t.arrivals[static_cast<std::size_t>(i)], &b = t.arrivals[static_cast<std::size_t>(j)];
        if (i == j) V(i, i) += std::pow(a.sigma_s * a.model_speed_mps, 2);
        if (a.beacon == b.beacon) V(i, j) += uncertainty_m * uncertainty_m;
      }
    return V;
  }
};

class NodeAdjustmentWith : public testing::TestWithParam<double> {};

TEST_P(NodeAdjustmentWith, SlackIsGeneralisedLeastSquares) {
  const double uncertainty_m = GetParam();
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Stop stop(seed);
    const NodeAdjustment found = stop.adjust(uncertainty_m);
    ASSERT_TRUE(found.converged) << seed;
    const Eigen::MatrixXd W = stop.noise_m2(uncertainty_m).inverse();
    Eigen::MatrixXd J(static_cast<Eigen::Index>(stop.t.arrivals.size()), 3);
    constexpr double kStep = 1e-5;
    for (int p = 0; p < 3; ++p)
      J.col(p) = (stop.residuals_m(kStep * Eigen::Vector3d::Unit(p)) -
                  stop.residuals_m(-kStep * Eigen::Vector3d::Unit(p))) /
                 (2 * kStep);
    const Eigen::VectorXd r = stop.residuals_m(Eigen::Vector3d::Zero());
    const Eigen::Matrix3d information = J.transpose() * W * J;
    // At the minimum the remaining step is almost zero, in sigmas.
    const Eigen::Vector3d gradient = J.transpose() * W * r;
    EXPECT_LT(std::sqrt(gradient.dot(information.ldlt().solve(gradient))), 1e-4) << seed;
    EXPECT_NEAR(found.cost, 0.5 * r.dot(W * r), 1e-6 * (1 + found.cost)) << seed;
    // The tangent of planar motion may turn with the vehicle: compare what does not depend on its axes.
    EXPECT_NEAR(found.information(2, 2), information(2, 2), 1e-5 * information(2, 2)) << seed;
    EXPECT_NEAR(found.information.topLeftCorner(2, 2).trace(), information.topLeftCorner(2, 2).trace(),
                1e-5 * information.trace())
        << seed;
    EXPECT_NEAR(found.information.determinant() / information.determinant(), 1.0, 1e-4) << seed;
  }
}
INSTANTIATE_TEST_SUITE_P(Slacks, NodeAdjustmentWith, testing::Values(0.0, 0.02, 0.5));

TEST(NodeAdjustment, LeavesOutWhatIsMarked) {
  Stop stop(3);
  stop.t.arrivals[0].tof_s += 0.01;
  stop.t.arrivals[0].rejection = Rejection::kLate;
  static_cast<void>(stop.adjust(0.0));
  EXPECT_LT((stop.t.nodes[0].T_map_vehicle.translation_m - stop.truth.translation_m).norm(), 0.02);
}

TEST(NodeAdjustment, MarksBeyondTheLimitAndReadmitsWellWithin) {
  Stop stop(5);
  stop.t.nodes[0].T_map_vehicle = stop.truth;
  ArrivalObservation& a = stop.t.arrivals[2];
  // Noise and slack: this deployment has no other errors.
  const double noise_m = a.sigma_s * a.model_speed_mps, limit_m = 4.0 * noise_m;
  EXPECT_NEAR(allowed_residual_m(stop.t, a, stop.model, 0.03, 4.0), 4.0 * std::hypot(noise_m, 0.03), 1e-9);
  const double exact_s = a.tof_s - stop.residuals_m(Eigen::Vector3d::Zero())[2] / a.model_speed_mps;
  const auto mark_at = [&](double share) {
    a.tof_s = exact_s + share * limit_m / a.model_speed_mps;
    return reject_arrivals(stop.t, stop.t.segments[0], stop.model, 0.0, 4.0);
  };
  EXPECT_FALSE(mark_at(0.99));
  EXPECT_EQ(a.rejection, Rejection::kUsed);
  EXPECT_TRUE(mark_at(1.01));
  EXPECT_EQ(a.rejection, Rejection::kLate);
  EXPECT_FALSE(mark_at(0.9));  // back only within 0.85 of it
  EXPECT_EQ(a.rejection, Rejection::kLate);
  EXPECT_TRUE(mark_at(0.8));
  EXPECT_EQ(a.rejection, Rejection::kUsed);
  EXPECT_TRUE(mark_at(-1.01));
  EXPECT_EQ(a.rejection, Rejection::kEarly);
}

/// Error of a stop at which one of eight arrivals is 3.5 sigmas late and the others are exact.
double error_with_a_late_arrival_m(const CorrelatedNoise& noise) {
  const Deployment d = test::with_receiver(hall(), {0.0, 0.0, 0.3});
  const EpochFixModel model = epoch_fix_model(d);
  std::mt19937_64 random(1);
  const Pose truth = random_pose(random);
  Trajectory t;
  set_epoch(t, hear(d, truth, {.range_m = 30.0}, random), {}, trajectory_model(d));
  t.nodes[0].T_map_vehicle = truth;
  t.nodes[0].placed = true;
  t.arrivals[2].tof_s += 3.5 * t.arrivals[2].sigma_s;
  CorrelatedArrivals weights(t, t.segments[0], noise, CorrelatedArrivals::Side::kSame);
  EXPECT_TRUE(adjust_and_reject(t, t.segments[0], model, 0.0, 4.0, weights).converged);
  EXPECT_EQ(t.arrivals[2].rejection, Rejection::kUsed);
  return test::position_error_m(t.nodes[0].T_map_vehicle, truth);
}

// The weight of a residual of 3.5 sigmas is (2 / 3.5)^2 = 0.33, more where the arrival moves the fix.
TEST(AdjustAndReject, GivesArrivalsBeyondTwoSigmasLessWeightWhereTheNoiseIsNotWhite) {
  EXPECT_LT(error_with_a_late_arrival_m({.sigma_s = 1e-12, .time_s = 1.0}),
            0.6 * error_with_a_late_arrival_m({}));
}

}  // namespace node_adjustment_test
}  // namespace octant
