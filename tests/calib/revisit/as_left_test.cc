// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A deployment after a visit, compared with the posterior of two Gaussians.
#include "calib/revisit/as_left.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "tests/calib/revisit/calibrated_hall.h"

namespace octant::test {
namespace as_left_test {

/// No change is accepted; this number of known parameters, and a visit with information `N`.
calib::VisitInformation visit_of(const KnownParameters& known, double share, Random& draws) {
  const Eigen::Index n = known.size();
  Eigen::MatrixXd A(n, n);
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = draws.normal();
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = share / std::sqrt(std::max(known.covariance(i, i), 1e-12));
  calib::VisitInformation visit;
  visit.N = scale.asDiagonal() * (A * A.transpose() / static_cast<double>(n)) * scale.asDiagonal();
  visit.gradient = Eigen::VectorXd(n);
  for (Eigen::Index i = 0; i < n; ++i) visit.gradient[i] = scale[i] * draws.normal();
  return visit;
}

TEST(AsLeft, IsThePosteriorOfWhatWasFree) {
  const Deployment before = calibrated_hall();
  const KnownParameters known = known_parameters(before);
  Random draws(7);
  const calib::VisitInformation visit = visit_of(known, 1.0, draws);
  const Eigen::VectorXd drift = 0.01 * known.covariance.diagonal();
  const calib::AsLeft left = calib::as_left(before, known, drift, Comparison(), visit, 1.0);
  std::vector<int> free;
  for (int i = 0; i < known.size(); ++i)
    if (known.covariance(i, i) > 0) free.push_back(i);
  Eigen::MatrixXd P = known.covariance(free, free);
  P.diagonal() += drift(free);
  const Eigen::MatrixXd C = (P.inverse() + visit.N(free, free)).inverse();
  const Eigen::VectorXd theta = known.value(free) + C * visit.gradient(free);
  ASSERT_EQ(left.deployment.covariance.parameters.size(), free.size());
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_EQ(left.deployment.covariance.parameters[i], known.parameters[static_cast<std::size_t>(free[i])]);
    for (std::size_t j = 0; j < free.size(); ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      // Inverses of inverses of matrices with elements from 1e-12 to 0.1.
      EXPECT_NEAR(left.deployment.covariance.matrix(row, column), C(row, column),
                  1e-6 * std::sqrt(C(row, row) * C(column, column)));
    }
  }
  const KnownParameters now = known_parameters(left.deployment);
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(now.value[free[i]], theta[row], 1e-6 * std::sqrt(C(row, row)));
  }
  EXPECT_TRUE(left.warnings.empty());
}

TEST(AsLeft, WhatWasHeldStaysHeld) {
  const Deployment before = calibrated_hall();
  const KnownParameters known = known_parameters(before);
  Random draws(8);
  const calib::AsLeft left = calib::as_left(before, known, Eigen::VectorXd::Zero(known.size()), Comparison(),
                                            visit_of(known, 1.0, draws), 1.0);
  for (std::size_t b = 0; b < before.beacons.size(); ++b) {
    if (before.beacons[b].status != BeaconStatus::kControlPoint) continue;
    EXPECT_EQ(left.deployment.beacons[b].position_m, before.beacons[b].position_m) << b;
    EXPECT_EQ(left.deployment.beacons[b].covariance_m2, Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
    EXPECT_EQ(left.deployment.beacons[b].status, BeaconStatus::kControlPoint);
  }
  EXPECT_EQ(left.deployment.datum.control_points, before.datum.control_points);
  EXPECT_EQ(left.deployment.datum.description, before.datum.description);
}

/// A comparison that holds one thing for changed.
Comparison changed(const KnownParameters& known, std::size_t beacon) {
  Comparison c;
  c.hypotheses = change_hypotheses(known);
  for (std::size_t k = 0; k < c.hypotheses.size(); ++k) {
    TestedChange tested;
    tested.hypothesis = k;
    tested.held = c.hypotheses[k].kind == ChangeKind::kBeaconMoved && c.hypotheses[k].owner == beacon;
    c.search.tested.push_back(tested);
  }
  return c;
}

TEST(AsLeft, AControlPointThatWasKnockedIsNoneAnyMore) {
  const Deployment before = calibrated_hall();
  const KnownParameters known = known_parameters(before);
  Random draws(9);
  calib::VisitInformation visit = visit_of(known, 1.0, draws);
  // Only the visit determines its present position: to 2 mm, 0.2 m along x.
  const int x = known.index_of(parameters::beacon_position(3, 0));
  for (int i = x; i < x + 3; ++i) {
    visit.N.row(i).setZero();
    visit.N.col(i).setZero();
    visit.N(i, i) = 1 / (0.002 * 0.002);
    visit.gradient[i] = i == x ? 0.2 * visit.N(i, i) : 0.0;
  }
  const calib::AsLeft left =
      calib::as_left(before, known, Eigen::VectorXd::Zero(known.size()), changed(known, 3), visit, 0.03);
  const DeploymentBeacon& b = left.deployment.beacons[3];
  EXPECT_EQ(b.status, BeaconStatus::kCalibrated);
  EXPECT_NEAR(b.position_m.x() - before.beacons[3].position_m.x(), 0.2, 1e-4);  // nothing old is believed
  EXPECT_NEAR(std::sqrt(b.covariance_m2(0, 0)), 0.002, 1e-6);
  EXPECT_EQ(left.deployment.datum.control_points, (std::vector<std::string>{"B0", "B6"}));
  EXPECT_NE(left.deployment.datum.description.find("B0, B6"), std::string::npos);
}

TEST(AsLeft, ABeaconThatTheVisitDoesNotTellIsLeftOutAndNamed) {
  const Deployment before = calibrated_hall();
  const KnownParameters known = known_parameters(before);
  Random draws(10);
  calib::VisitInformation visit = visit_of(known, 1.0, draws);
  const int x = known.index_of(parameters::beacon_position(4, 0));
  for (int i = x; i < x + 3; ++i) {
    visit.N.row(i).setZero();
    visit.N.col(i).setZero();
    visit.gradient[i] = 0.0;
  }
  const calib::AsLeft left =
      calib::as_left(before, known, Eigen::VectorXd::Zero(known.size()), changed(known, 4), visit, 0.03);
  EXPECT_EQ(left.deployment.beacons[4].status, BeaconStatus::kUndetermined);
  ASSERT_EQ(left.warnings.size(), 1U);
  EXPECT_NE(left.warnings[0].find("beacon B4 changed"), std::string::npos) << left.warnings[0];
}

}  // namespace as_left_test
}  // namespace octant::test
