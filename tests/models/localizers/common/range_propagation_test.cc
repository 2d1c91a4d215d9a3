// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Covariance of a method's pose, compared with one Jacobian of everything on which its ranges depend.
#include "models/localizers/common/range_propagation.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"
#include "tests/models/localizers/hall.h"

namespace octant::test {
namespace range_propagation_test {

/// A hall in which no parameter is exact, and some ranges of a method that converts them to a pose.
struct Method {
  Deployment d = with_receiver(with_receiver(hall(5), {0.4, 0.1, 0.3}), {-0.3, 0.2, 0.5});
  Pose T;
  std::vector<PairRange> pairs;
  std::vector<Eigen::Vector3d> gains;

  explicit Method(Random& draws) {
    T = Pose::planar(draws.uniform(3, 17), draws.uniform(2, 10), draws.uniform(-3, 3));
    d.speed_sigma_mps = 0.3;
    for (DeploymentBeacon& b : d.beacons) {
      Eigen::Matrix3d A;
      for (Eigen::Index i = 0; i < 9; ++i) A(i) = 0.01 * draws.normal();
      b.covariance_m2 = A * A.transpose();
      b.delay_sigma_s = 1e-5 * draws.uniform();
    }
    for (DeploymentReceiver& r : d.receivers) {
      r.sigma_m = 0.002 * draws.normal3().cwiseAbs();
      r.delay_sigma_s = 1e-6;
    }
    for (int b = 0; b < 5; ++b)
      for (int r = 0; r < 2; ++r) {
        if ((b + r) % 3 == 2) continue;  // not heard
        PairRange pair;
        pair.beacon = BeaconId(b);
        pair.receiver = ReceiverId(r);
        pair.sigma_m = 0.005 * draws.uniform(1, 2);
        pair.gain_mps = 340.0;
        pair.by_speed_s = draws.uniform(0.01, 0.04);
        pairs.push_back(pair);
        gains.push_back(draws.normal3());
      }
  }
  [[nodiscard]] RangePropagation propagation() const {
    RangePropagation p(d);
    for (std::size_t i = 0; i < pairs.size(); ++i) p.add(gains[i], pairs[i], T, d);
    return p;
  }
  [[nodiscard]] double distance_m(const PairRange& pair, const Eigen::Vector3d& beacon_off,
                                  const Eigen::Vector3d& receiver_off) const {
    return (T * (d.receivers[pair.receiver.index()].position_m + receiver_off) -
            d.beacons[pair.beacon.index()].position_m - beacon_off)
        .norm();
  }
};

RC_GTEST_PROP(RangePropagation, IsThatOfOneJacobianOfEverything, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const Method m(draws);
  // Columns: noise of each pair; of each beacon x, y, z, delay; of each receiver; the speed.
  const auto pairs = static_cast<Eigen::Index>(m.pairs.size());
  const Eigen::Index of_beacons = pairs, of_receivers = of_beacons + 4 * 5, speed = of_receivers + 4 * 2;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, speed + 1), C = Eigen::MatrixXd::Zero(speed + 1, speed + 1);
  constexpr double kStep = 1e-5;
  for (Eigen::Index i = 0; i < pairs; ++i) {
    const PairRange& pair = m.pairs[static_cast<std::size_t>(i)];
    const Eigen::Vector3d& gain = m.gains[static_cast<std::size_t>(i)];
    J.col(i) = gain;
    C(i, i) = pair.sigma_m * pair.sigma_m;
    const Eigen::Index b = of_beacons + 4 * static_cast<Eigen::Index>(pair.beacon.index()),
                       r = of_receivers + 4 * static_cast<Eigen::Index>(pair.receiver.index());
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = kStep * Eigen::Vector3d::Unit(k);
      J.col(b + k) += gain * (m.distance_m(pair, e, none) - m.distance_m(pair, -e, none)) / (2 * kStep);
      J.col(r + k) += gain * (m.distance_m(pair, none, e) - m.distance_m(pair, none, -e)) / (2 * kStep);
    }
    J.col(b + 3) -= gain * pair.gain_mps;
    J.col(r + 3) -= gain * pair.gain_mps;
    J.col(speed) += gain * pair.by_speed_s;
  }
  for (std::size_t k = 0; k < 5; ++k) {
    const Eigen::Index b = of_beacons + 4 * static_cast<Eigen::Index>(k);
    C.block<3, 3>(b, b) = m.d.beacons[k].covariance_m2;
    C(b + 3, b + 3) = std::pow(m.d.beacons[k].delay_sigma_s, 2);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Index r = of_receivers + 4 * static_cast<Eigen::Index>(k);
    for (Eigen::Index i = 0; i < 3; ++i) C(r + i, r + i) = std::pow(m.d.receivers[k].sigma_m[i], 2);
    C(r + 3, r + 3) = std::pow(m.d.receivers[k].delay_sigma_s, 2);
  }
  C(speed, speed) = 0.09;
  const Eigen::Matrix3d want = J * C * J.transpose();
  // Central differences of distances: 1e-10.
  RC_ASSERT((m.propagation().covariance(m.d) - want).cwiseAbs().maxCoeff() <
            1e-8 * want.cwiseAbs().maxCoeff());
}

TEST(RangePropagation, ClearedIsAsNew) {
  Random draws(2);
  const Method m(draws);
  RangePropagation p = m.propagation();
  p.clear();
  EXPECT_EQ(p.covariance(m.d), Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
  p.add(m.gains[0], m.pairs[0], m.T, m.d);
  RangePropagation fresh(m.d);
  fresh.add(m.gains[0], m.pairs[0], m.T, m.d);
  EXPECT_EQ(p.covariance(m.d), fresh.covariance(m.d));
}

// Two arrivals of one beacon share its error; of two beacons they do not.
TEST(RangePropagation, WhatArrivalsShareDoesNotAverageOut) {
  Random draws(3);
  Method m(draws);
  m.d.speed_sigma_mps = 0.0;
  for (DeploymentReceiver& r : m.d.receivers) r.sigma_m.setZero(), r.delay_sigma_s = 0.0;
  for (DeploymentBeacon& b : m.d.beacons) b.covariance_m2.setZero(), b.delay_sigma_s = 1e-5;
  PairRange pair;
  pair.gain_mps = 340.0;
  const Eigen::Vector3d gain(1, 0, 0);
  RangePropagation same(m.d), other(m.d);
  for (const int b : {0, 1}) {
    pair.receiver = ReceiverId(b);
    pair.beacon = BeaconId(0);
    same.add(0.5 * gain, pair, m.T, m.d);
    pair.beacon = BeaconId(b);
    other.add(0.5 * gain, pair, m.T, m.d);
  }
  const double one_m2 = std::pow(340.0 * 1e-5, 2);
  EXPECT_NEAR(same.covariance(m.d)(0, 0), one_m2, 1e-15);
  EXPECT_NEAR(other.covariance(m.d)(0, 0), one_m2 / 2, 1e-15);
}

TEST(CalibrationVariance, IsTheMeanOverHorizontalDirections) {
  Random draws(4);
  Method m(draws);
  PairRange pair = m.pairs[0];
  DeploymentBeacon& b = m.d.beacons[pair.beacon.index()];
  b.delay_sigma_s = m.d.receivers[pair.receiver.index()].delay_sigma_s = m.d.speed_sigma_mps = 0.0;
  double sum = 0.0;
  constexpr int kDirections = 360;
  for (int i = 0; i < kDirections; ++i) {
    const Eigen::Vector3d u(std::cos(2 * M_PI * i / kDirections), std::sin(2 * M_PI * i / kDirections), 0.0);
    sum += u.dot(b.covariance_m2 * u) +
           u.dot(m.d.receivers[pair.receiver.index()].sigma_m.cwiseAbs2().asDiagonal() * u);
  }
  EXPECT_NEAR(calibration_variance_m2(pair, m.d), sum / kDirections, 1e-15);
  b.delay_sigma_s = 1e-5;
  m.d.speed_sigma_mps = 0.5;
  EXPECT_NEAR(calibration_variance_m2(pair, m.d) - sum / kDirections,
              std::pow(340.0 * 1e-5, 2) + std::pow(pair.by_speed_s * 0.5, 2), 1e-15);
}

TEST(SightOf, IsFromBeaconToReceiverAndUpwardsWhereTheyMeet) {
  Random draws(5);
  const Method m(draws);
  const Sight sight = sight_of(m.T, BeaconId(2), ReceiverId(1), m.d);
  const Eigen::Vector3d end = m.d.beacons[2].position_m + sight.distance_m * sight.direction;
  EXPECT_LT((end - m.T * m.d.receivers[1].position_m).norm(), 1e-14);
  EXPECT_NEAR(sight.direction.norm(), 1.0, 1e-15);
  Deployment d = m.d;
  d.beacons[0].position_m = m.T * d.receivers[0].position_m;
  const Sight none = sight_of(m.T, BeaconId(0), ReceiverId(0), d);
  EXPECT_EQ(none.distance_m, 0.0);
  EXPECT_EQ(none.direction, Eigen::Vector3d(0, 0, 1));
}

}  // namespace range_propagation_test
}  // namespace octant::test
