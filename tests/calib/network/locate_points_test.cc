// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Approximate coordinates of survey networks, and the checks before an adjustment.
#include "calib/network/locate_points.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "calib/network/check_network.h"

namespace octant::test {
namespace locate_points_test {

const std::vector<Eigen::Vector3d> kTruth = {
    {0, 0, 0}, {100, 10, 0}, {190, 60, 0}, {250, 20, 0}, {300, 50, 0}};

double azimuth(std::size_t from, std::size_t to) {
  const Eigen::Vector3d v = kTruth[to] - kTruth[from];
  return std::atan2(v.y(), v.x());
}

/// Traverse between two fixed points, without an orientation at either end.
Network traverse() {
  Network n;
  n.sets = static_cast<int>(kTruth.size());
  for (std::size_t p = 0; p < kTruth.size(); ++p) {
    const bool fixed = p == 0 || p + 1 == kTruth.size();
    const CoordinateRole role = fixed ? CoordinateRole::kFixed : CoordinateRole::kFree;
    n.points.push_back({.id = std::to_string(p),
                        .p_map_m = fixed ? kTruth[p] : Eigen::Vector3d::Zero(),
                        .role = {role, role, CoordinateRole::kAbsent},
                        .known = {fixed, fixed, false}});
    for (const std::size_t to : {p - 1, p + 1}) {
      if (to >= kTruth.size()) continue;
      SurveyObservation o{
          .kind = SurveyKind::kDirection, .from = static_cast<int>(p), .to = static_cast<int>(to)};
      o.set = static_cast<int>(p);
      o.value = azimuth(p, to) + 0.3 * static_cast<double>(p);
      n.observations.push_back(o);
      o.kind = SurveyKind::kHorizontalDistance;
      o.value = (kTruth[to] - kTruth[p]).norm();
      n.observations.push_back(o);
    }
  }
  return n;
}

TEST(LocatePoints, ComputesATraverseWithoutOrientationInALocalFrame) {
  const calib::LocatedNetwork located = calib::locate_points(traverse());
  EXPECT_TRUE(located.missing.empty());
  EXPECT_EQ(located.computed, (std::vector<std::string>{"1", "2", "3"}));
  for (std::size_t p = 0; p < kTruth.size(); ++p)
    EXPECT_LT((located.network.points[p].p_map_m - kTruth[p]).norm(), 1e-9) << p;
}

TEST(LocatePoints, DoesNotChooseBetweenMirrorImages) {
  Network n = traverse();
  std::erase_if(n.observations, [](const SurveyObservation& o) {
    return o.kind == SurveyKind::kDirection || o.to == 2 || o.from == 2;
  });
  n.observations.front().to = 1;
  EXPECT_EQ(calib::locate_points(n).missing, (std::vector<std::string>{"1", "2", "3"}));
}

TEST(CheckNetwork, RefusesInvalidNetworks) {
  EXPECT_TRUE(calib::check_network(traverse()));
  const auto refuses = [](auto change) {
    Network n = traverse();
    change(n);
    const auto checked = calib::check_network(n);
    return !checked && checked.error().code == Errc::kBadInput;
  };
  EXPECT_TRUE(refuses([](Network& n) { n.observations.clear(); }));
  EXPECT_TRUE(refuses([](Network& n) { n.observations[0].to = 5; }));
  EXPECT_TRUE(refuses([](Network& n) { n.observations[0].to = n.observations[0].from; }));
  EXPECT_TRUE(refuses([](Network& n) { n.observations[0].set = n.sets; }));
  EXPECT_TRUE(refuses([](Network& n) { n.observations[0].sigma = 0.0; }));
  EXPECT_TRUE(refuses([](Network& n) { n.observations[0].value = std::nan(""); }));
  EXPECT_TRUE(refuses([](Network& n) { n.covariances.push_back({0, -Eigen::Matrix2d::Identity()}); }));
  EXPECT_TRUE(refuses([](Network& n) { n.covariances.assign(2, {0, Eigen::Matrix2d::Identity()}); }));
  EXPECT_TRUE(refuses([](Network& n) {
    n.covariances.push_back({static_cast<int>(n.observations.size()) - 1, Eigen::Matrix2d::Identity()});
  }));
  EXPECT_TRUE(refuses([](Network& n) {
    for (NetworkPoint& p : n.points) p.role.fill(CoordinateRole::kFixed);
  }));
}

}  // namespace locate_points_test
}  // namespace octant::test
