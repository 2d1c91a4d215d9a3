// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The calibration's part of a fix's covariance, compared with a fix that is solved again for other
// parameters.
#include "models/localizers/common/calibration_part.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/models/localizers/hall.h"
#include "tests/support/numeric.h"

namespace octant::test {
namespace calibration_part_test {

/// A stop of a vehicle with three receivers, solved; of its beacons, delays and the speed little is known.
struct Stop {
  Deployment d = with_receiver(with_receiver(with_receiver(hall(), {0.3, 0.0, 0.3}), {-0.2, 0.25, 0.3}),
                               {-0.2, -0.25, 0.3});
  Trajectory t;
  SharedState state;

  Stop() {
    JointCovariance& joint = d.covariance;
    for (const std::size_t b : {0U, 3U, 5U}) {
      for (std::size_t i = 0; i < 3; ++i) joint.parameters.push_back(parameters::beacon_position(b, i));
      joint.parameters.push_back(parameters::beacon_delay(b));
    }
    for (std::size_t i = 0; i < 3; ++i) joint.parameters.push_back(parameters::receiver_position(1, i));
    joint.parameters.push_back(parameters::receiver_delay(2));
    joint.parameters.push_back(parameters::site_delay());
    joint.parameters.push_back(parameters::speed());
    const auto n = static_cast<Eigen::Index>(joint.parameters.size());
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd A(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        A(i, j) = unit(joint.parameters[static_cast<std::size_t>(i)]) * normal(random);
    joint.matrix = A * A.transpose();
    state = shared_state(d);
    const std::vector<Arrival> arrivals = hear(d, Pose::planar(7, 5, 0.6), {.noise_s = 1e-5}, random);
    set_epoch(t, arrivals, {}, trajectory_model(d));
    t.nodes[0].T_map_vehicle = Pose::planar(7.1, 5.1, 0.5);
    t.nodes[0].placed = true;
    solve_states();
  }
  static double unit(const ParameterId& id) {
    return id.kind == ParameterKind::kBeaconPosition || id.kind == ParameterKind::kReceiverPosition ? 1e-3
           : id.kind == ParameterKind::kSpeed                                                       ? 0.1
                                                                                                    : 3e-6;
  }
  void solve_states() { octant::solve_states(t, t.segments[0], state, {}, 50); }
  /// Pose of the fix when the parameters have these errors.
  [[nodiscard]] Eigen::VectorXd pose_for(const Eigen::VectorXd& off) const {
    Stop other = *this;
    for (std::size_t k = 0; k < d.covariance.parameters.size(); ++k) {
      const ParameterId& id = d.covariance.parameters[k];
      *value_in(other.state, id) += off[static_cast<Eigen::Index>(k)];
    }
    for (int i = 0; i < 4; ++i) other.solve_states();
    const Pose& T = other.t.nodes[0].T_map_vehicle;
    return Eigen::Vector3d(T.translation_m.x(), T.translation_m.y(), T.heading_rad());
  }
};

TEST(CalibrationPart, IsHowTheFixFollowsTheParameters) {
  const Stop stop;
  PoseCovariance P = Eigen::Matrix3d::Identity() * 1e-6;
  const PoseCovariance before = P;
  CalibrationPart(stop.d).add_to(P, stop.t, stop.t.segments[0], stop.state);
  const auto n = static_cast<Eigen::Index>(stop.d.covariance.parameters.size());
  Eigen::MatrixXd by(3, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double step = 0.1 * Stop::unit(stop.d.covariance.parameters[static_cast<std::size_t>(k)]);
    const Eigen::VectorXd e = step * Eigen::VectorXd::Unit(n, k);
    by.col(k) = (stop.pose_for(e) - stop.pose_for(-e)) / (2 * step);
  }
  const Eigen::Matrix3d want = by * stop.d.covariance.matrix * by.transpose();
  // Gauss-Newton ignores the curvature of the residuals: noise of 3 mm at distances of metres. A solved state
  // is accurate to a ten-thousandth of its sigma. The effect is negligible relative to pi^2 of the unknown
  // heading.
  EXPECT_LT((P - before - want).cwiseAbs().maxCoeff(), 0.02 * want.cwiseAbs().maxCoeff());
  EXPECT_GT(want(0, 0), 1e-7) << "a millimetre or so is no rounding";
}

TEST(CalibrationPart, OfNothingStatedChangesNothing) {
  Stop stop;
  stop.d.covariance = {};
  PoseCovariance P = Eigen::Matrix3d::Identity();
  const CalibrationPart part(stop.d);
  EXPECT_EQ(part.covariance().rows(), 0);
  part.add_to(P, stop.t, stop.t.segments[0], stop.state);
  EXPECT_EQ(P, PoseCovariance(Eigen::Matrix3d::Identity()));
}

TEST(CalibrationPart, OfBeaconsThatWereNotHeardIsNone) {
  Stop stop;
  for (ArrivalObservation& a : stop.t.arrivals)
    if (a.beacon == BeaconId(0)) a.rejection = Rejection::kBeaconUnusable;
  JointCovariance of_first;
  for (std::size_t i = 0; i < 3; ++i) of_first.parameters.push_back(parameters::beacon_position(0, i));
  of_first.matrix = Eigen::Matrix3d::Identity();
  stop.d.covariance = of_first;
  PoseCovariance P = Eigen::Matrix3d::Identity();
  CalibrationPart(stop.d).add_to(P, stop.t, stop.t.segments[0], stop.state);
  EXPECT_EQ(P, PoseCovariance(Eigen::Matrix3d::Identity()));
}

// A shift of the whole map by a metre, with relative positions known to a millimetre: rounding must not make
// the covariance indefinite.
TEST(CalibrationPart, LeavesAPositiveCovarianceWhereNearlyAllCancels) {
  Stop stop;
  JointCovariance joint;
  for (std::size_t b = 0; b < 8; ++b)
    for (std::size_t i = 0; i < 3; ++i) joint.parameters.push_back(parameters::beacon_position(b, i));
  Eigen::MatrixXd turn(24, 1);
  for (Eigen::Index b = 0; b < 8; ++b) {
    const Eigen::Vector3d p =
        stop.d.beacons[static_cast<std::size_t>(b)].position_m - Eigen::Vector3d(7, 5, 0);
    turn.middleRows(3 * b, 3) = Eigen::Vector3d(-p.y(), p.x(), 0);
  }
  joint.matrix = 1e8 * turn * turn.transpose();
  stop.d.covariance = joint;
  PoseCovariance P = 1e-7 * Eigen::Matrix3d::Identity();
  CalibrationPart(stop.d).add_to(P, stop.t, stop.t.segments[0], stop.state);
  EXPECT_TRUE(P.allFinite());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen{Eigen::Matrix3d(P)};
  EXPECT_GT(eigen.eigenvalues()[0], 0.0);
  EXPECT_GT(P(2, 2), 1e6) << "the heading turns with the map";
}

}  // namespace calibration_part_test
}  // namespace octant::test
