// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// One filter against least squares in full, and its considered parameters against one covariance of all.
#include "models/localizers/drive/drive_filter.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/models/localizers/hall.h"
#include "tests/support/numeric.h"

namespace octant::test {
namespace drive_filter_test {

const Pose kTruth = Pose::planar(7.0, 5.0, 0.6);

/// Arrivals of a stop in a hall, and the input of a filter.
struct Hall {
  Deployment d = with_receiver(with_receiver(hall(), {0.4, 0.1, 0.3}), {-0.3, 0.2, 0.3});
  EpochFixModel model;
  Trajectory t;

  explicit Hall(double noise_s = 1e-5, bool calibrated = false) {
    if (calibrated) {
      for (std::size_t b = 0; b < d.beacons.size(); ++b)
        for (std::size_t i = 0; i < 2; ++i)
          d.covariance.parameters.push_back(parameters::beacon_position(b, i));
      d.covariance.parameters.push_back(parameters::speed());
      const auto n = static_cast<Eigen::Index>(d.covariance.parameters.size());
      std::mt19937_64 random(2);
      std::normal_distribution<double> normal;
      Eigen::MatrixXd A(n, n);
      for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = 0.005 * normal(random);
      A.bottomRows(1) *= 20;  // m/s
      d.covariance.matrix = A * A.transpose();
    }
    model = epoch_fix_model(d);
    model.correlated = {};
    std::mt19937_64 random(5);
    set_epoch(t, hear(d, kTruth, {.noise_s = noise_s}, random), {}, trajectory_model(d));
  }
  /// Predicted time of an arrival at a pose, with given errors of the calibrated parameters.
  [[nodiscard]] double tof_s(const ArrivalObservation& a, const Eigen::Vector3d& at,
                             const Eigen::VectorXd& off = {}) const {
    SharedState state = model.state;
    for (Eigen::Index k = 0; k < off.size(); ++k)
      *value_in(state, d.covariance.parameters[static_cast<std::size_t>(k)]) += off[k];
    const Pose T = Pose::planar(at.x(), at.y(), at.z());
    PathInput in = path_of(t, a, state);
    in.T_map_vehicle = &T;
    return predict_arrival_value(in).tof_s;
  }
};

Eigen::Vector3d vector_of(const Pose& T) {
  return {T.translation_m.x(), T.translation_m.y(), T.heading_rad()};
}

Eigen::Matrix3d start_covariance() { return Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal(); }

TEST(DriveFilter, StartsWhereItIsTold) {
  const Hall hall;
  DriveFilter filter(hall.model, 4.0, 0.0);
  filter.start(kTruth, start_covariance());
  EXPECT_EQ(filter.pose().translation_m, kTruth.translation_m);
  EXPECT_EQ(filter.covariance(), start_covariance());
  EXPECT_FALSE(filter.is_lost());
}

// Prior and arrivals together, by Gauss and Newton on all of them at once.
TEST(DriveFilter, OfArrivalsAtOneInstantIsTheirLeastSquares) {
  const Hall hall;
  const Eigen::Vector3d start = vector_of(kTruth) + Eigen::Vector3d(0.02, -0.03, 0.01);
  const Eigen::Matrix3d prior = 0.01 * start_covariance();  // ranges are straight within it
  DriveFilter filter(hall.model, 10.0, 0.0);
  filter.start(Pose::planar(start.x(), start.y(), start.z()), prior);
  for (const ArrivalObservation& a : hall.t.arrivals) ASSERT_EQ(filter.update(hall.t, a), Rejection::kUsed);
  Eigen::Vector3d x = start;
  Eigen::Matrix3d N;
  for (int round = 0; round < 10; ++round) {
    N = prior.inverse();
    Eigen::Vector3d g = N * (start - x);
    for (const ArrivalObservation& a : hall.t.arrivals) {
      const Eigen::RowVector3d H = numeric_jacobian(
          [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
            return Eigen::VectorXd::Constant(1, hall.tof_s(a, at));
          },
          x, 1e-5);
      N += H.transpose() * H / (a.sigma_s * a.sigma_s);
      g += H.transpose() * (a.tof_s - hall.tof_s(a, x)) / (a.sigma_s * a.sigma_s);
    }
    x += N.inverse() * g;
  }
  const Eigen::Matrix3d C = N.inverse();
  // One by one, each is linearised at the present state of the filter: a few hundredths of a sigma.
  EXPECT_LT((vector_of(filter.pose()) - x).cwiseQuotient(C.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff(),
            0.05);
  EXPECT_LT((filter.covariance() - C).cwiseAbs().maxCoeff(), 0.05 * C.cwiseAbs().maxCoeff());
}

TEST(DriveFilter, PredictsByTheStepsDerivativeAndItsNoise) {
  const Hall hall;
  DriveFilter filter(hall.model, 4.0, 0.0);
  filter.start(kTruth, start_covariance());
  const Pose step = Pose::planar(0.3, -0.1, 0.2);
  const OdometryObservation whole{
      .node = 0, .T_before_after = step, .distance_sigma_m = 0.03, .heading_sigma_rad = 0.02};
  filter.predict(step, whole, 0.25);
  const Eigen::MatrixXd F = numeric_jacobian(
      [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
        return vector_of(Pose::planar(x[0], x[1], x[2]) * step);
      },
      vector_of(kTruth), 1e-5);
  Eigen::Matrix3d want = F * start_covariance() * F.transpose();
  want.diagonal() += 0.25 * Eigen::Vector3d(9e-4, 9e-4, 4e-4);
  EXPECT_LT((filter.covariance() - want).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((vector_of(filter.pose()) - vector_of(kTruth * step)).norm(), 1e-14);
}

TEST(DriveFilter, LeavesOutWhatIsBeyondTheGateAndSaysOnWhichSide) {
  Hall hall(0.0);
  DriveFilter filter(hall.model, 4.0, 0.0);
  filter.start(kTruth, 1e-12 * Eigen::Matrix3d::Identity());
  ArrivalObservation a = hall.t.arrivals[0];
  const double exact_s = a.tof_s;
  for (const auto& [sigmas, want] : {std::pair{3.9, Rejection::kUsed},
                                     {-3.9, Rejection::kUsed},
                                     {4.1, Rejection::kLate},
                                     {-4.1, Rejection::kEarly}}) {
    a.tof_s = exact_s + sigmas * a.sigma_s;
    const Eigen::Matrix3d before = filter.covariance();
    EXPECT_EQ(filter.fits(hall.t, a), want == Rejection::kUsed);
    EXPECT_EQ(filter.covariance(), before) << "asking changes nothing";
    EXPECT_EQ(filter.update(hall.t, a), want) << sigmas;
    if (want != Rejection::kUsed) {
      EXPECT_EQ(filter.covariance(), before);
    }
  }
  // Slack widens it: 4 sigmas of 10 mm besides are 116 us.
  a.tof_s = exact_s + 1e-4;
  EXPECT_FALSE(filter.fits(hall.t, a));
  filter.set_range_uncertainty(0.01);
  EXPECT_TRUE(filter.fits(hall.t, a));
}

TEST(DriveFilter, IsLostWhenMostOfTheRecentArrivalsAreBeyondTheGate) {
  Hall hall(0.0);
  DriveFilter filter(hall.model, 4.0, 0.0);
  filter.start(kTruth, 1e-12 * Eigen::Matrix3d::Identity());
  ArrivalObservation late = hall.t.arrivals[0], good = late;
  late.tof_s += 1e-2;
  int rejected = 0;
  while (!filter.is_lost() && rejected < 1000) {
    EXPECT_EQ(filter.update(hall.t, late), Rejection::kLate);
    ++rejected;
  }
  // (1 - 1/30)^n < 0.35
  EXPECT_EQ(rejected, static_cast<int>(std::ceil(std::log(0.35) / std::log(1 - 1.0 / 30))));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(filter.update(hall.t, good), Rejection::kUsed);
  EXPECT_FALSE(filter.is_lost());
}

TEST(DriveFilter, OfAnUnusableBeaconTakesNothing) {
  Hall hall;
  hall.model.beacon_usable.assign(8, false);
  DriveFilter filter(hall.model, 4.0, 0.0);
  filter.start(kTruth, start_covariance());
  EXPECT_FALSE(filter.fits(hall.t, hall.t.arrivals[0]));
  EXPECT_EQ(filter.update(hall.t, hall.t.arrivals[0]), Rejection::kBeaconUnusable);
  EXPECT_EQ(filter.covariance(), start_covariance());
}

/// Schmidt's filter written out: one covariance of the pose and all considered parameters, whose gain is the
/// pose's alone.
struct DenseSchmidt {
  Eigen::Vector3d x;
  Eigen::MatrixXd P;

  void predict(const Pose& step, double distance2, double heading2) {
    const Eigen::MatrixXd F = numeric_jacobian(
        [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
          return vector_of(Pose::planar(at[0], at[1], at[2]) * step);
        },
        x, 1e-5);
    Eigen::MatrixXd whole = Eigen::MatrixXd::Identity(P.rows(), P.cols());
    whole.topLeftCorner<3, 3>() = F;
    P = (whole * P * whole.transpose()).eval();
    P.diagonal().head<3>() += Eigen::Vector3d(distance2, distance2, heading2);
    x = vector_of(Pose::planar(x[0], x[1], x[2]) * step);
  }
  void update(const Hall& hall, const ArrivalObservation& a) {
    const Eigen::Index n = P.rows() - 3;
    Eigen::Vector3d there = x;
    Eigen::RowVectorXd H(n + 3);
    Eigen::VectorXd gain(n + 3);
    for (int round = 0; round < 3; ++round) {  // as often as the filter's
      const Eigen::Vector3d at = there;
      H.head<3>() = numeric_jacobian(
          [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
            return Eigen::VectorXd::Constant(1, hall.tof_s(a, v));
          },
          at, 1e-5);
      H.tail(n) = numeric_jacobian(
          [&](const Eigen::VectorXd& off) -> Eigen::VectorXd {
            return Eigen::VectorXd::Constant(1, hall.tof_s(a, round == 0 ? at : x, off));
          },
          Eigen::VectorXd::Zero(n), 1e-5);
      gain = P * H.transpose() / (H * P * H.transpose() + a.sigma_s * a.sigma_s);
      gain.tail(n).setZero();
      there = x + gain.head<3>() * (a.tof_s - hall.tof_s(a, at) + H.head<3>().dot(at - x));
    }
    const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n + 3, n + 3) - gain * H;
    P = (A * P * A.transpose() + a.sigma_s * a.sigma_s * gain * gain.transpose()).eval();
    x = there;
  }
};

TEST(DriveFilter, ConsidersTheCalibrationAsOneCovarianceOfAllDoes) {
  const Hall hall(1e-5, true);
  const CalibrationPart calibration(hall.d);
  DriveFilter filter(hall.model, 10.0, 0.0, &calibration);
  const Eigen::Vector3d start = vector_of(kTruth) + Eigen::Vector3d(0.02, -0.03, 0.01);
  const Pose step = Pose::planar(0.05, 0.0, 0.02);
  const OdometryObservation whole{
      .node = 0, .T_before_after = step, .distance_sigma_m = 0.01, .heading_sigma_rad = 0.005};
  filter.start(Pose::planar(start.x(), start.y(), start.z()), 0.01 * start_covariance());
  const Eigen::Index n = hall.d.covariance.matrix.rows();
  DenseSchmidt dense{start, Eigen::MatrixXd::Zero(n + 3, n + 3)};
  dense.P.topLeftCorner<3, 3>() = 0.01 * start_covariance();
  dense.P.bottomRightCorner(n, n) = hall.d.covariance.matrix;
  for (std::size_t i = 0; i < hall.t.arrivals.size(); ++i) {
    ASSERT_EQ(filter.update(hall.t, hall.t.arrivals[i]), Rejection::kUsed);
    dense.update(hall, hall.t.arrivals[i]);
    if (i % 5 != 4) continue;
    filter.predict(step, whole, 1.0);
    filter.predict(step.inverse(), whole, 1.0);
    dense.predict(step, 1e-4, 2.5e-5);
    dense.predict(step.inverse(), 1e-4, 2.5e-5);
  }
  const Eigen::Matrix3d want = dense.P.topLeftCorner<3, 3>();
  EXPECT_LT((filter.covariance() - want).cwiseAbs().maxCoeff(), 1e-3 * want.cwiseAbs().maxCoeff());
  EXPECT_LT(
      (vector_of(filter.pose()) - dense.x).cwiseQuotient(want.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff(),
      1e-2);
  // It remains in the covariance, far above the noise averaged over that number of arrivals.
  DriveFilter believing(hall.model, 10.0, 0.0);
  believing.start(kTruth, 0.01 * start_covariance());
  for (const ArrivalObservation& a : hall.t.arrivals) static_cast<void>(believing.update(hall.t, a));
  EXPECT_GT(want(0, 0), 4 * believing.covariance()(0, 0));
}

TEST(DriveFilter, TakesOverWhatAnotherHolds) {
  const Hall hall(1e-5, true);
  const CalibrationPart calibration(hall.d);
  DriveFilter a(hall.model, 4.0, 0.0, &calibration), b(hall.model, 4.0, 0.0, &calibration);
  a.start(kTruth, 0.01 * start_covariance());
  b.start(Pose(), start_covariance());
  for (std::size_t i = 0; i < 5; ++i) static_cast<void>(a.update(hall.t, hall.t.arrivals[i]));
  b.copy_state(a);
  for (std::size_t i = 5; i < hall.t.arrivals.size(); ++i)
    EXPECT_EQ(a.update(hall.t, hall.t.arrivals[i]), b.update(hall.t, hall.t.arrivals[i]));
  EXPECT_EQ(a.pose().translation_m, b.pose().translation_m);
  EXPECT_EQ(a.covariance(), b.covariance());
}

}  // namespace drive_filter_test
}  // namespace octant::test
