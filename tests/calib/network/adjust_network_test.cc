// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Adjustment of survey networks without arrivals: closed forms, numeric derivatives, and properties of
// datums.
#include "calib/network/adjust_network.h"

#include <cmath>

#include <gtest/gtest.h>

#include "calib/errors/reliability.h"
#include "calib/network/survey_row.h"

namespace octant::test {
namespace adjust_network_test {

NetworkPoint height(const std::string& id, double z_m, CoordinateRole role) {
  return {id, {0.0, 0.0, z_m}, {CoordinateRole::kAbsent, CoordinateRole::kAbsent, role}};
}

SurveyObservation level(int from, int to, double value, double sigma) {
  return {.kind = SurveyKind::kHeightDifference, .from = from, .to = to, .value = value, .sigma = sigma};
}

/// Levelling loop of three equal lines with a closing error of 3 mm.
Network loop(CoordinateRole first) {
  Network n;
  const CoordinateRole other = first == CoordinateRole::kDatum ? first : CoordinateRole::kFree;
  n.points = {height("A", 10.0, first), height("B", 11.0, other), height("C", 12.0, other)};
  n.observations = {level(0, 1, 1.001, 0.001), level(1, 2, 1.001, 0.001), level(2, 0, -1.999, 0.001)};
  return n;
}

/// Four points in space, with every kind of observation, displaced from the truth by `error_m`.
Network every_kind(CoordinateRole role, double error_m) {
  Network n;
  const std::vector<Eigen::Vector3d> truth = {{0, 0, 1}, {40, 3, 2}, {35, 30, 4}, {-4, 28, 3}};
  for (std::size_t p = 0; p < truth.size(); ++p)
    n.points.push_back({std::string(1, static_cast<char>('A' + p)), truth[p], {role, role, role}});
  n.sets = 4;
  n.scales = n.constants = 1;
  for (int from = 0; from < 4; ++from)
    for (int to = 0; to < 4; ++to) {
      if (from == to) continue;
      const SurveyObservation sight{
          .from = from, .to = to, .set = from, .instrument_height_m = 1.5, .target_height_m = 1.2};
      for (const SurveyKind kind :
           {SurveyKind::kDirection, SurveyKind::kZenithAngle, SurveyKind::kSlopeDistance,
            SurveyKind::kHorizontalDistance, SurveyKind::kHeightDifference}) {
        SurveyObservation o = sight;
        o.kind = kind;
        o.sigma = kind <= SurveyKind::kZenithAngle ? 1e-5 : 0.001;
        if (kind == SurveyKind::kSlopeDistance) o.scale = o.constant = 0;
        n.observations.push_back(o);
      }
    }
  const calib::NetworkColumns columns = calib::network_columns(n);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(columns.size);
  for (std::size_t p = 0; p < 4; ++p)
    for (std::size_t i = 0; i < 3; ++i)
      if (columns.point[p][i] >= 0) x[columns.point[p][i]] = truth[p][static_cast<int>(i)];
  for (SurveyObservation& o : n.observations) o.value = -calib::survey_row(n, columns, o, x).misclosure;
  for (std::size_t p = 1; p < 4; ++p)
    n.points[p].p_map_m += error_m * Eigen::Vector3d(1.0, p == 2 ? -1.0 : 1.0, 0.5);
  return n;
}

TEST(AdjustNetwork, SharesTheClosingErrorOfALoop) {
  const calib::NetworkSolution s = calib::adjust_network(loop(CoordinateRole::kFixed));
  ASSERT_EQ(s.status, calib::NetworkStatus::kConverged);
  EXPECT_NEAR(s.points_m[1].z(), 11.0, 1e-12);
  EXPECT_NEAR(s.points_m[2].z(), 12.0, 1e-12);
  EXPECT_NEAR(s.variance_factor, 3.0, 1e-9);  // three residuals of one sigma, one degree of freedom
  EXPECT_NEAR(s.covariance(0, 0), 2.0 / 3.0 * 1e-6, 1e-15);  // one line parallel to two in series
  for (const calib::ObservationResult& o : s.observations) {
    EXPECT_NEAR(o.redundancy, 1.0 / 3.0, 1e-9);
    EXPECT_NEAR(std::abs(o.w), std::sqrt(3.0), 1e-9);
    EXPECT_NEAR(o.detectable_bias, calib::kDelta0 * 1e-3 * std::sqrt(3.0), 1e-9);
  }
}

TEST(AdjustNetwork, HasInnerConstraintsOverDatumPoints) {
  const calib::NetworkSolution s = calib::adjust_network(loop(CoordinateRole::kDatum));
  ASSERT_EQ(s.status, calib::NetworkStatus::kConverged);
  EXPECT_EQ(s.defect, 1);
  EXPECT_NEAR(s.points_m[0].z() + s.points_m[1].z() + s.points_m[2].z(), 33.0, 1e-9);
  EXPECT_NEAR(s.covariance.sum(), 0.0, 1e-15);               // the mean height is a definition
  EXPECT_NEAR(s.covariance(0, 0), 2.0 / 9.0 * 1e-6, 1e-15);  // pseudo-inverse of a triangle
}

TEST(AdjustNetwork, NamesPointsWithoutDatum) {
  const calib::NetworkSolution s = calib::adjust_network(loop(CoordinateRole::kFree));
  EXPECT_EQ(s.status, calib::NetworkStatus::kUndetermined);
  EXPECT_EQ(s.undetermined, (std::vector<int>{0, 1, 2}));
}

TEST(AdjustNetwork, CorrelatedObservationsEqualTheirSum) {
  Network n;
  n.points = {height("A", 0.0, CoordinateRole::kFree)};
  n.observations = {{.kind = SurveyKind::kZ, .from = 0, .value = 1.0},
                    {.kind = SurveyKind::kZ, .from = 0, .value = 2.0}};
  n.covariances = {{0, (Eigen::Matrix2d() << 1.0, 0.5, 0.5, 4.0).finished()}};
  const calib::NetworkSolution s = calib::adjust_network(n);
  ASSERT_EQ(s.status, calib::NetworkStatus::kConverged);
  EXPECT_NEAR(s.points_m[0].z(), 1.125, 1e-12);  // weights (4 - 0.5) and (1 - 0.5) of 4
  EXPECT_NEAR(s.covariance(0, 0), 3.75 / 4.0, 1e-12);
}

TEST(SurveyRow, HasTheNumericDerivative) {
  const Network n = every_kind(CoordinateRole::kFree, 0.1);
  const calib::NetworkColumns columns = calib::network_columns(n);
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(columns.size, -7.0, 9.0).array().sin() * 20.0;
  for (const SurveyObservation& o : n.observations) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(columns.size);
    for (const auto& [c, value] : calib::survey_row(n, columns, o, x).entries) row[c] += value;
    for (int c = 0; c < columns.size; ++c) {
      const Eigen::VectorXd step = Eigen::VectorXd::Unit(columns.size, c) * 1e-5;
      const double change = calib::survey_row(n, columns, o, x - step).misclosure -
                            calib::survey_row(n, columns, o, x + step).misclosure;
      EXPECT_NEAR(std::remainder(change, 2 * M_PI) / 2e-5, row[c], 1e-6 * (1.0 + std::abs(row[c])));
    }
  }
}

TEST(AdjustNetwork, FindsTheShapeOfAFreeNetworkInSpace) {
  const Network n = every_kind(CoordinateRole::kDatum, 0.3), truth = every_kind(CoordinateRole::kDatum, 0.0);
  const calib::NetworkSolution s = calib::adjust_network(n);
  ASSERT_EQ(s.status, calib::NetworkStatus::kConverged);
  EXPECT_EQ(s.defect, 4);  // three shifts and the rotation about the vertical
  for (std::size_t p = 0; p < 4; ++p)
    for (std::size_t q = 0; q < p; ++q)
      EXPECT_NEAR((s.points_m[p] - s.points_m[q]).norm(),
                  (truth.points[p].p_map_m - truth.points[q].p_map_m).norm(), 1e-8);
  double sum = 0.0;
  for (const calib::ObservationResult& o : s.observations) sum += o.redundancy;
  EXPECT_NEAR(sum, s.redundancy, 1e-6);
}

}  // namespace adjust_network_test
}  // namespace octant::test
