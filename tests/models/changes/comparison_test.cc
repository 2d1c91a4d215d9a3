// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/comparison.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "models/simulator/random.h"

namespace octant {
namespace comparison_test {

constexpr const char* kAxes[3] = {"/x_m", "/y_m", "/z_m"};

/// Eight beacons in a hall, the first four control points, each delay its own, one receiver.
Deployment hall() {
  Deployment d;
  d.site = "hall";
  d.created = "2026-01-01T00:00:00Z";
  d.digest = "before";
  d.datum.control_points = {"B0", "B1", "B2", "B3"};
  d.timing.delay_per.beacon = true;
  d.medium.temperature_degC = 20.0;
  d.speed_sigma_mps = 0.1;
  std::vector<double> sigma;
  for (int b = 0; b < 8; ++b) {
    DeploymentBeacon beacon;
    beacon.name = "B" + std::to_string(b);
    beacon.position_m = {5.0 * (b % 4), b < 4 ? 0.0 : 9.0, 2.5 + 0.1 * b};
    beacon.delay_sigma_s = 2e-6;
    beacon.status = b < 4 ? BeaconStatus::kControlPoint : BeaconStatus::kCalibrated;
    for (int i = 0; i < 3 && b >= 4; ++i) {
      beacon.covariance_m2(i, i) = 4e-6;
      d.covariance.parameters.push_back(
          parameters::beacon_position(static_cast<std::size_t>(b), static_cast<std::size_t>(i)));
      sigma.push_back(2e-3);
    }
    d.covariance.parameters.push_back(parameters::beacon_delay(static_cast<std::size_t>(b)));
    sigma.push_back(2e-6);
    d.beacons.push_back(beacon);
  }
  d.vehicles.push_back({"robot", 0, 1});
  DeploymentReceiver receiver;
  receiver.name = "r0";
  receiver.vehicle = VehicleId(std::size_t{0});
  receiver.sigma_m.setConstant(1e-3);
  d.receivers.push_back(receiver);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    d.covariance.parameters.push_back(parameters::receiver_position(0, axis));
    sigma.push_back(1e-3);
  }
  d.covariance.parameters.push_back(parameters::speed());
  sigma.push_back(0.1);
  d.covariance.matrix = Eigen::Map<Eigen::VectorXd>(sigma.data(), static_cast<Eigen::Index>(sigma.size()))
                            .cwiseAbs2()
                            .asDiagonal();
  return d;
}

TEST(Comparison, NothingIsFoundWhereNothingChanged) {
  EXPECT_TRUE(compare(hall(), hall(), Drift{}).changes.empty());
}

TEST(Comparison, AMoveAndADelayByNameAndSize) {
  Deployment now = hall();
  now.beacons[5].position_m += Eigen::Vector3d(0.03, -0.04, 0.0);
  now.beacons[2].delay_s += 60e-6;
  const Comparison found = compare(hall(), now, Drift{});
  ASSERT_EQ(found.changes.size(), 2U);
  const Change& delay = found.changes[0].kind == ChangeKind::kDelay ? found.changes[0] : found.changes[1];
  const Change& move = found.changes[0].kind == ChangeKind::kDelay ? found.changes[1] : found.changes[0];
  EXPECT_EQ(move.kind, ChangeKind::kBeaconMoved);
  EXPECT_EQ(move.subject, "B5");
  EXPECT_NEAR(move.size, 0.05, 3 * move.sigma);
  EXPECT_EQ(delay.subject, "B2");
  EXPECT_NEAR(delay.size, 60e-6, 2e-12);  // its prior takes two parts in 1e8
  EXPECT_NEAR(delay.sigma, std::sqrt(17.0) * 1e-6, 1e-12);
  EXPECT_LT(move.p, kFalseAlarm);
}

TEST(Comparison, ExchangedBeaconsAreOneChange) {
  Deployment now = hall();
  std::swap(now.beacons[5].position_m, now.beacons[7].position_m);
  const Comparison found = compare(hall(), now, Drift{});
  ASSERT_EQ(found.changes.size(), 1U);
  EXPECT_EQ(found.changes[0].kind, ChangeKind::kExchanged);
  EXPECT_EQ(found.changes[0].subject, "B5, B7");
  EXPECT_NEAR(found.changes[0].size, (hall().beacons[5].position_m - hall().beacons[7].position_m).norm(),
              1e-9);
}

/// All control points were surveyed again in another frame: no beacon moved relative to the others.
TEST(Comparison, AMapThatMovedAsAWholeIsTheDatum) {
  Deployment now = hall();
  const Eigen::Rotation2Dd turn(0.01);
  for (DeploymentBeacon& b : now.beacons) {
    b.position_m.head<2>() = turn * b.position_m.head<2>();
    b.position_m += Eigen::Vector3d(0.3, -0.1, 0.0);
  }
  const Comparison found = compare(hall(), now, Drift{});
  ASSERT_EQ(found.changes.size(), 1U);
  EXPECT_EQ(found.changes[0].kind, ChangeKind::kDatum);
  // Motion of the beacons' centre, (7.5, 4.5): a turn by 0.01 moves it by (-0.045, 0.075) in addition.
  EXPECT_NEAR(found.changes[0].size, std::hypot(0.3 - 0.045, -0.1 + 0.075), 2e-3);
}

/// A second visit that determines the beacons to a millimetre, combined by recalibration as in a Kalman
/// filter.
Deployment recalibrated(const Deployment& before, const Eigen::VectorXd& measured,
                        const std::vector<ParameterId>& released) {
  const KnownParameters known = known_parameters(before);
  std::vector<int> free;
  Eigen::MatrixXd P = known.covariance;
  P.diagonal() += drift_variances(known, Drift{});
  P += released_covariance(known, {released, false}, before.motion);
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(i)];
    const bool told = std::find(released.begin(), released.end(), p) != released.end();
    if (told || known.covariance(i, i) > 0) free.push_back(static_cast<int>(i));
  }
  Eigen::VectorXd sigma(known.size());
  for (Eigen::Index i = 0; i < known.size(); ++i) sigma[i] = std::sqrt(drift_variances(known, Drift{})[i]);
  const Eigen::MatrixXd Pf = P(free, free);
  const Eigen::VectorXd R = sigma.cwiseAbs2(), Rf = R(free);
  const Eigen::MatrixXd K = Pf * (Pf + Eigen::MatrixXd(Rf.asDiagonal())).inverse();
  const Eigen::VectorXd step = K * (measured - known.value)(free);
  const Eigen::MatrixXd C = (Eigen::MatrixXd::Identity(Pf.rows(), Pf.cols()) - K) * Pf;
  Deployment now = before;
  now.digest = "now";
  now.previous = Previous{before.digest, before.created, Drift{}, {released, false}, {}};
  now.covariance.parameters.clear();
  now.covariance.matrix = 0.5 * (C + C.transpose());
  for (std::size_t k = 0; k < free.size(); ++k) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(free[k])];
    now.covariance.parameters.push_back(p);
    const double value = known.value[free[k]] + step[static_cast<Eigen::Index>(k)];
    if (p.kind == ParameterKind::kBeaconPosition) now.beacons[p.owner].position_m[p.component] = value;
    if (p.kind == ParameterKind::kBeaconDelay) now.beacons[p.owner].delay_s = value;
    if (p.kind == ParameterKind::kReceiverPosition) now.receivers[p.owner].position_m[p.component] = value;
    if (p.kind == ParameterKind::kSpeed) now.speed_offset_mps = value;
  }
  return now;
}

/// The errors of both are correlated: treated as independent, a change that the first calibration restrains
/// would not be detected.
TEST(Comparison, ARecalibrationIsHeldAgainstWhatItsVisitSaid) {
  const Deployment before = hall();
  const KnownParameters known = known_parameters(before);
  Eigen::VectorXd measured = known.value;
  measured[known.index_of({ParameterKind::kBeaconPosition, 6, 0})] += 0.02;
  const Deployment now = recalibrated(before, measured,
                                      {parameters::beacon_position(6, 0), parameters::beacon_position(6, 1),
                                       parameters::beacon_position(6, 2)});
  ASSERT_TRUE(is_derived(now, before));
  const Comparison found = compare(before, now, Drift{});
  ASSERT_EQ(found.changes.size(), 1U);
  EXPECT_EQ(found.changes[0].subject, "B6");
  EXPECT_NEAR(found.changes[0].size, 0.02, 1e-5);
  // The visit's own millimetre, the earlier covariance, and the drift.
  EXPECT_NEAR(found.changes[0].sigma, std::sqrt(1e-6 + 4e-6 + 1e-6), 1e-5);
  // Without released parameters the visit still shows it: the effect of the prior is removed.
  const Comparison held_back = compare(before, recalibrated(before, measured, {}), Drift{});
  ASSERT_EQ(held_back.changes.size(), 1U);
  EXPECT_NEAR(held_back.changes[0].size, 0.02, 1e-5);
}

TEST(Comparison, MonthsBetweenDates) {
  EXPECT_NEAR(months_between("2026-01-01T00:00:00Z", "2026-07-01T12:00:00Z"), 181.5 / 30.44, 1e-9);
  EXPECT_EQ(months_between("2026-07-01T00:00:00Z", "2026-01-01T00:00:00Z"), 0.0);
  EXPECT_EQ(months_between("yesterday", "2026-01-01T00:00:00Z"), 0.0);
}

}  // namespace comparison_test
}  // namespace octant
