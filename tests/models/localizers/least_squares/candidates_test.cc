// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Search for a pose without an initial value: its list of the best compared with a brute-force one, and its
// proposals with the truth.
#include "models/localizers/least_squares/candidates.h"

#include <algorithm>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "models/physics/pose.h"
#include "tests/models/localizers/least_squares/search_world.h"

namespace octant {
namespace candidates_test {

/// Far apart, so that no candidates are merged: the list is the start of the sorted scores.
TEST(Candidates, TopListIsTheBestOfAll) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> score(0.0, 100.0);
  TopList top(8, 0.1, 0.1);
  std::vector<double> all;
  EXPECT_GT(top.worst(), 1e300);
  for (int k = 0; k < 500; ++k) {
    all.push_back(score(random));
    top.offer({{1.0 * k, 0.0, 0.0, 0.0}, all.back()});
  }
  std::sort(all.begin(), all.end());
  ASSERT_EQ(top.list().size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(top.list()[i].score, all[i]);
  EXPECT_EQ(top.worst(), all[7]);
}

TEST(Candidates, OfNeighboursOnlyTheBestStays) {
  TopList top(4, 0.5, 0.2);
  top.offer({{0.0, 0.0, 3.1, 0.0}, 5.0});
  top.offer({{0.1, 0.0, -3.1, 0.0}, 3.0});  // 0.08 rad away, across the turn
  top.offer({{0.2, 0.0, 3.1, 0.0}, 4.0});
  top.offer({{0.1, 0.0, 2.0, 0.0}, 6.0});  // another heading
  top.offer({{2.0, 0.0, 3.1, 0.0}, 7.0});  // another place
  ASSERT_EQ(top.list().size(), 3U);
  EXPECT_EQ(top.list()[0].score, 3.0);
  EXPECT_EQ(top.list()[1].score, 6.0);
  EXPECT_EQ(top.list()[2].score, 7.0);
}

/// Six beacons along walls, four receivers without axes on a cross of 25 cm.
SearchProblem problem_at(const PlanarState& truth, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const Eigen::Vector3d beacons[] = {{0, 0.5, 2.5}, {7, 0, 2.4},   {12, 3, 2.7},
                                     {11, 9, 2.5},  {4, 9.5, 2.3}, {-0.5, 6, 2.6}};
  Eigen::Vector3d levers[4];
  for (int k = 0; k < 4; ++k)
    levers[k] = {0.25 * std::cos(k * std::numbers::pi / 2 + 0.2),
                 0.25 * std::sin(k * std::numbers::pi / 2 + 0.2), 0.3};
  SearchProblem problem = test::search_problem_at(truth, beacons, levers, 0.004);
  problem.span_m = 0.0;
  for (SearchRange& r : problem.ranges) {
    r.range_m += truth.offset_m + 0.004 * normal(random);
    if (uniform(random) < 0.15) r.range_m += 3 * uniform(random);  // an echo
    problem.span_m = std::max(problem.span_m, r.range_m);
  }
  problem.speed_mps = 343.0;
  return problem;
}

PlanarState random_state(std::mt19937_64& random) {
  std::uniform_real_distribution<double> x(1.0, 10.0), y(1.0, 8.0), turn(-3.14, 3.14);
  return {x(random), y(random), turn(random), 0.0};
}

/// For one of the coarse headings, an eighth of a turn apart, the circles of two direct arrivals meet within
/// the effect of the heading's error on the lever arm: 2 * 0.25 m * pi / 8.
TEST(Candidates, PairsProposeAPlaceNearTheTruth) {
  std::mt19937_64 random(2);
  for (int k = 0; k < 50; ++k) {
    const PlanarState truth = random_state(random);
    const SearchProblem problem = problem_at(truth, random);
    Consensus consensus(problem);
    consensus.set_extra_sigma(0.1);
    TopList top(10, 0.1, 0.3);
    propose_from_pairs(problem, {}, consensus, top);
    double nearest = INFINITY;
    for (const Candidate& c : top.list())
      nearest = std::min(nearest, std::hypot(c.state.x_m - truth.x_m, c.state.y_m - truth.y_m));
    EXPECT_LT(nearest, 0.25) << k;
  }
}

/// All but a few of a hundred worlds are found, with scores no worse than that of the truth.
TEST(Candidates, SearchFindsThePose) {
  std::mt19937_64 random(3);
  int found = 0;
  for (int k = 0; k < 100; ++k) {
    const PlanarState truth = random_state(random);
    const SearchProblem problem = problem_at(truth, random);
    const SearchResult result = search_pose(problem);
    ASSERT_FALSE(result.poses.empty()) << k;
    ASSERT_EQ(result.poses.size(), result.information.size());
    for (std::size_t i = 1; i < result.poses.size(); ++i)
      EXPECT_LE(result.poses[i - 1].score, result.poses[i].score);
    const PlanarState& best = result.poses[0].state;
    // The refined pose is that of a Cauchy loss, so a little of the mixture's score may be left.
    EXPECT_LT(result.poses[0].score, Consensus(problem).score(truth) + 2.0) << k;
    found += std::hypot(best.x_m - truth.x_m, best.y_m - truth.y_m) < 0.02 &&
             std::abs(wrap_angle(best.heading_rad - truth.heading_rad)) < 0.05;
  }
  EXPECT_GE(found, 98);
}

/// Four receivers on a cross 40 cm ahead and four as far behind, with a reception of 60 degrees each, among
/// four beacons at a room's corners: each beacon is received by one or two of them, four times. Beacons are
/// known to 4 mm.
SearchProblem head_and_tail_at(const PlanarState& truth, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Eigen::Vector3d beacons[] = {{0, 0, 1.5}, {6.1, 4.9, 1.4}, {0, 5, 1.5}, {5.8, 0, 1.55}};
  SearchProblem problem;
  const Pose T = Pose::planar(truth.x_m, truth.y_m, truth.heading_rad);
  for (std::size_t b = 0; b < 4; ++b) {
    const double bias_m = 0.004 * normal(random);
    problem.group_first.push_back(problem.ranges.size());
    problem.group_bias_m.push_back(0.004);
    for (int k = 0; k < 8; ++k) {
      const double turn = k % 4 * std::numbers::pi / 2;
      SearchRange r;
      r.axis = {std::cos(turn), std::sin(turn)};
      r.p_lever_m = {(k < 4 ? 0.4 : -0.4) + 0.08 * r.axis.x(), 0.08 * r.axis.y(), 0.3};
      r.p_beacon_map_m = beacons[b];
      r.hearing_cosine = 0.5;
      const Eigen::Vector3d towards = T.rotation.conjugate() * (beacons[b] - T * r.p_lever_m);
      if (towards.head<2>().normalized().dot(r.axis) < 0.5 || (k < 4) != (b % 2 == 0)) continue;
      r.beacon = BeaconId(b);
      r.sigma_m = 0.0034;
      for (int ping = 0; ping < 4; ++ping) {
        r.range_m = (T * r.p_lever_m - beacons[b]).norm() + bias_m + r.sigma_m * normal(random);
        r.observation = problem.ranges.size();
        problem.ranges.push_back(r);
        problem.span_m = std::max(problem.span_m, r.range_m);
      }
    }
  }
  problem.group_first.push_back(problem.ranges.size());
  problem.lever_m = 0.48;
  problem.median_sigma_m = 0.0034;
  return problem;
}

/// A pose with a shadowed beacon may be centimetres from the one on which all beacons agree, with an edge of
/// reception or a flat valley between them. A shadowed beacon costs at least twice the margin here; if the
/// valley has a kink, a few of thousands are missed.
TEST(Candidates, NoBeaconIsTakenToBeInAShadowWhereAllAgree) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> x(0.6, 5.4), y(0.6, 4.4), turn(-3.14, 3.14);
  SearchOptions options;
  options.headings = 16;
  options.keep = 20;
  int missed = 0;
  for (int k = 0; k < 3000; ++k) {
    const PlanarState truth{x(random), y(random), turn(random), 0.0};
    const SearchProblem problem = head_and_tail_at(truth, random);
    const SearchResult result = search_pose(problem, options);
    ASSERT_FALSE(result.poses.empty()) << k;
    missed += result.poses[0].score > Consensus(problem).score(truth) + 4.0 ? 1 : 0;
  }
  RecordProperty("missed", missed);
  EXPECT_LE(missed, 6);
}

/// Two circles that are a metre apart: no pose explains both, and the one between is found all the same.
TEST(Candidates, RangesThatDoNotMeetHaveAPoseToo) {
  const Eigen::Vector3d beacons[] = {{0, 0, 2.5}, {10, 0, 2.5}}, levers[] = {{0, 0, 0.3}};
  SearchProblem problem = test::search_problem_at({5.0, 0.0, 0.0, 0.0}, beacons, levers, 0.004);
  for (SearchRange& r : problem.ranges) r.range_m -= 0.5;
  const SearchResult result = search_pose(problem);
  ASSERT_FALSE(result.poses.empty());
  EXPECT_NEAR(result.poses[0].state.x_m, 5.0, 0.6);
}

TEST(Candidates, SearchFindsTheCycleOffsetToo) {
  std::mt19937_64 random(4);
  int found = 0;
  for (int k = 0; k < 30; ++k) {
    PlanarState truth = random_state(random);
    truth.offset_m = 1.7;
    SearchProblem problem = problem_at(truth, random);
    problem.has_offset = true;
    const SearchResult result = search_pose(problem);
    ASSERT_FALSE(result.poses.empty()) << k;
    const PlanarState& best = result.poses[0].state;
    found += std::hypot(best.x_m - truth.x_m, best.y_m - truth.y_m) < 0.04 &&
             std::abs(best.offset_m - truth.offset_m) < 0.04;
  }
  EXPECT_GE(found, 28);
}

}  // namespace candidates_test
}  // namespace octant
