// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Networks as they arrive: without approximate coordinates, with blunders, partly undetermined, and large.
#include "calib/network/solve_network.h"

#include <cmath>

#include <gtest/gtest.h>

namespace octant::test {
namespace solve_network_test {

constexpr double kSigma_m = 0.001;

NetworkPoint height(int id, CoordinateRole role) {
  return {.id = std::to_string(id),
          .role = {CoordinateRole::kAbsent, CoordinateRole::kAbsent, role},
          .known = {false, false, role == CoordinateRole::kFixed}};
}

SurveyObservation level(int from, int to, double value) {
  return {.kind = SurveyKind::kHeightDifference, .from = from, .to = to, .value = value, .sigma = kSigma_m};
}

/// Levelling line of `size` points, each 1 m above the one before, without approximate heights.
Network line(int size, CoordinateRole first, CoordinateRole last, CoordinateRole rest) {
  Network n;
  for (int p = 0; p < size; ++p) n.points.push_back(height(p, p == 0 ? first : p + 1 == size ? last : rest));
  if (last == CoordinateRole::kFixed) n.points.back().p_map_m.z() = size - 1.0;
  for (int p = 1; p < size; ++p) n.observations.push_back(level(p - 1, p, 1.0));
  return n;
}

TEST(SolveNetwork, HasTheClosedFormOfALongLine) {
  constexpr int kPoints = 3001;
  const auto solved = calib::solve_network(
      line(kPoints, CoordinateRole::kFixed, CoordinateRole::kFixed, CoordinateRole::kFree));
  ASSERT_TRUE(solved);
  ASSERT_EQ(solved->solution.status, calib::NetworkStatus::kConverged);
  EXPECT_EQ(solved->solution.covariance.size(), 0);  // too large for a full matrix
  constexpr int k = 1000, kLines = kPoints - 1;
  EXPECT_NEAR(solved->solution.points_m[k].z(), k, 1e-9);
  EXPECT_NEAR(solved->solution.point_covariances_m2[k](2, 2), kSigma_m * kSigma_m * k * (kLines - k) / kLines,
              1e-12);
  EXPECT_NEAR(solved->solution.observations[7].redundancy, 1.0 / kLines, 1e-9);
}

TEST(SolveNetwork, HasInnerConstraintsInALargeNetwork) {
  constexpr int kPoints = 1500;
  Network network = line(kPoints, CoordinateRole::kDatum, CoordinateRole::kDatum, CoordinateRole::kDatum);
  for (int p = 0; p < kPoints; ++p) {
    network.points[static_cast<std::size_t>(p)].p_map_m.z() = p + 0.01 * std::sin(p);
    network.points[static_cast<std::size_t>(p)].known[2] = true;
  }
  network.observations.push_back(level(0, kPoints - 1, kPoints - 1.0));
  const auto solved = calib::solve_network(network);
  ASSERT_TRUE(solved);
  ASSERT_EQ(solved->solution.status, calib::NetworkStatus::kConverged);
  EXPECT_EQ(solved->solution.defect, 1);
  double shift_m = 0.0;
  for (std::size_t p = 0; p < kPoints; ++p)
    shift_m += solved->solution.points_m[p].z() - network.points[p].p_map_m.z();
  EXPECT_NEAR(shift_m, 0.0, 1e-6);
  // Pseudo-inverse of a ring: (n^2 - 1) / (12 n) lines.
  const double expected_m2 = kSigma_m * kSigma_m * (kPoints * kPoints - 1.0) / (12.0 * kPoints);
  for (const std::size_t p : {0UL, 700UL})
    EXPECT_NEAR(solved->solution.point_covariances_m2[p](2, 2), expected_m2, 1e-4 * expected_m2);
}

TEST(SolveNetwork, LeavesOutWhatIsNotDetermined) {
  Network network = line(5, CoordinateRole::kFixed, CoordinateRole::kFree, CoordinateRole::kFree);
  network.points.push_back(height(5, CoordinateRole::kFree));   // not observed
  network.points.push_back(height(6, CoordinateRole::kFree));   // connected with the next point alone
  network.points.push_back(height(7, CoordinateRole::kDatum));  // not observed, but in the datum
  network.points[6].p_map_m.z() = network.points[7].p_map_m.z() = 3.0;
  network.points[5].known[2] = network.points[6].known[2] = network.points[7].known[2] = true;
  network.points.push_back(height(8, CoordinateRole::kFree));
  network.observations.push_back(level(6, 8, 1.0));
  const auto solved = calib::solve_network(network);
  ASSERT_TRUE(solved);
  ASSERT_EQ(solved->solution.status, calib::NetworkStatus::kConverged);
  EXPECT_EQ(solved->undetermined, (std::vector<std::string>{"5", "7", "6", "8"}));
  EXPECT_EQ(solved->unusable, 1U);
  EXPECT_NEAR(solved->solution.points_m[4].z(), 4.0, 1e-12);
}

TEST(SolveNetwork, LeavesOutObservationsBeyondTheLimit) {
  Network network = line(4, CoordinateRole::kFixed, CoordinateRole::kFixed, CoordinateRole::kFree);
  for (int p = 0; p < 4; ++p) {
    network.points[static_cast<std::size_t>(p)].p_map_m.z() = p;
    network.points[static_cast<std::size_t>(p)].known[2] = true;
  }
  network.observations.push_back(level(1, 2, 11.0));
  const auto all = calib::solve_network(network);
  const auto limited = calib::solve_network(network, {.outlier_limit_m = 1.0});
  ASSERT_TRUE(all && limited);
  EXPECT_TRUE(all->outlying.empty());
  ASSERT_EQ(limited->outlying.size(), 1U);
  EXPECT_EQ(limited->outlying[0].value, 11.0);
  EXPECT_GT(all->solution.points_m[2].z(), 2.5);
  EXPECT_NEAR(limited->solution.points_m[2].z(), 2.0, 1e-12);
}

/// Triangulation of a strip of triangles by directions alone: the fixed points are at its ends.
TEST(SolveNetwork, LocatesATriangulationWithoutDistances) {
  constexpr int kPoints = 10;
  Network network;
  std::vector<Eigen::Vector3d> truth;
  for (int p = 0; p < kPoints; ++p) truth.emplace_back(60.0 * p, p % 2 == 0 ? 0.0 : 90.0 + 3.0 * p, 0.0);
  for (int p = 0; p < kPoints; ++p) {
    const bool fixed = p == 0 || p + 1 == kPoints;
    const CoordinateRole role = fixed ? CoordinateRole::kFixed : CoordinateRole::kFree;
    network.points.push_back({.id = std::to_string(p),
                              .p_map_m = fixed ? truth[static_cast<std::size_t>(p)] : Eigen::Vector3d::Zero(),
                              .role = {role, role, CoordinateRole::kAbsent},
                              .known = {fixed, fixed, false}});
    for (const int to : {p - 2, p - 1, p + 1, p + 2}) {
      if (to < 0 || to >= kPoints) continue;
      const Eigen::Vector3d v = truth[static_cast<std::size_t>(to)] - truth[static_cast<std::size_t>(p)];
      network.observations.push_back({.kind = SurveyKind::kDirection,
                                      .from = p,
                                      .to = to,
                                      .set = p,
                                      .value = std::atan2(v.y(), v.x()) + 0.4 * p,
                                      .sigma = 1e-5});
    }
  }
  network.sets = kPoints;
  const auto solved = calib::solve_network(network);
  ASSERT_TRUE(solved);
  ASSERT_EQ(solved->solution.status, calib::NetworkStatus::kConverged);
  EXPECT_EQ(solved->computed.size(), kPoints - 2U);
  for (std::size_t p = 0; p < kPoints; ++p)
    EXPECT_LT((solved->solution.points_m[p] - truth[p]).norm(), 1e-6) << p;
}

}  // namespace solve_network_test
}  // namespace octant::test
