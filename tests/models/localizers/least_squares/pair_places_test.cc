// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The bounds of what poses at a pair's place may score, against the scores of such poses.
#include "models/localizers/least_squares/pair_places.h"

#include <algorithm>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "models/physics/pose.h"
#include "tests/models/localizers/least_squares/search_world.h"

namespace octant {
namespace pair_places_test {

constexpr double kSigmaM = 0.004;
constexpr int kHeadings = 8;

/// Beacons along walls; a pose that explains two ranges of different beacons, with any others: direct from
/// another position, and some of them late or early.
struct PairWorld {
  PlanarState pose;
  SearchProblem problem;
  std::array<std::size_t, 2> pair;

  explicit PairWorld(std::mt19937_64& random, double lever_m) {
    const Eigen::Vector3d beacons[] = {{0, 1, 2.5},  {6, 0, 2.4},    {12, 2, 2.6},
                                       {11, 9, 2.5}, {5, 9.5, 2.45}, {-0.5, 7, 2.55}};
    const Eigen::Vector3d levers[] = {
        {lever_m, 0, 0.3}, {-0.5 * lever_m, 0.8 * lever_m, 0.3}, {-0.5 * lever_m, -0.8 * lever_m, 0.3}};
    std::uniform_real_distribution<double> uniform;
    std::normal_distribution<double> normal;
    const auto anywhere = [&] {
      const double x = 12 * uniform(random), y = 9 * uniform(random);
      return PlanarState{x, y, 2 * std::numbers::pi * (uniform(random) - 0.5), 0.0};
    };
    pose = anywhere();
    const PlanarState other = uniform(random) < 0.5 ? pose : anywhere();
    problem = test::search_problem_at(other, beacons, levers, kSigmaM);
    for (double& bias_m : problem.group_bias_m) bias_m = uniform(random) < 0.3 ? 0.01 : 0.0;
    for (SearchRange& r : problem.ranges)
      r.range_m += kSigmaM * normal(random) + (uniform(random) < 0.3 ? 2.0 * uniform(random) - 0.3 : 0.0);
    const auto first = static_cast<std::size_t>(18 * uniform(random));
    pair = {first, (first + 3 + static_cast<std::size_t>(13 * uniform(random))) % 18};
    if (pair[0] / 3 == pair[1] / 3) pair[1] = (pair[1] + 3) % 18;
    const Pose T = Pose::planar(pose.x_m, pose.y_m, pose.heading_rad);
    for (const std::size_t i : pair) {
      SearchRange& r = problem.ranges[i];
      r.range_m = (T * r.p_lever_m - r.p_beacon_map_m).norm() + 2.0 * kSigmaM * (2 * uniform(random) - 1);
    }
  }
};

constexpr double kNoBound = 1e9;

/// Neither the region of the pose nor the heading next to it is excluded if the bound is the score of the
/// pose.
TEST(PairPlaces, NoPoseScoresLessThanItsPlaceAllows) {
  std::mt19937_64 random(1);
  int flat = 0, narrower = 0, tight = 0;
  for (int k = 0; k < 3000; ++k) {
    PairWorld w(random, k % 3 == 0 ? 0.3 : 0.06);
    Consensus consensus(w.problem);
    const Discord discord = discord_of(w.problem, consensus);
    const double score = consensus.score(w.pose);
    PairPlaces places(w.problem, consensus, discord, kHeadings);
    bool is_proposed = false;
    for (PairPlace& place : places.within(std::span(&w.pair, 1), score)) {
      EXPECT_LE(place.least_score, score);
      if (place.is_flat) {
        const auto part = places.narrowed(place, score);
        ASSERT_TRUE(part) << k;
        EXPECT_LE(part->least_score, score);
        EXPECT_LE(std::hypot(w.pose.x_m - part->x_m, w.pose.y_m - part->y_m), part->reach_m + 1e-9) << k;
        narrower += part->reach_m < 0.7 * place.reach_m;
        place = *part;
      }
      flat += place.is_flat;
      tight += place.least_score > 0.5 * score;
      TopList top(2 * kHeadings, 1e-6, 1e-6);
      places.propose(place, consensus, score, top);
      for (const Candidate& c : top.list())
        is_proposed = is_proposed || std::abs(wrap_angle(c.state.heading_rad - w.pose.heading_rad)) <=
                                         std::numbers::pi / kHeadings + 1e-9;
    }
    EXPECT_TRUE(is_proposed) << k;
  }
  EXPECT_GT(flat, 50) << "circles that about touch are among them";
  EXPECT_GT(narrower, flat / 4) << "of whose lenses a part is left";
  EXPECT_GT(tight, 500) << "and bounds that say something";
}

/// A place away from where the ranges come from is given up.
TEST(PairPlaces, TheBoundLeavesFewPlaces) {
  std::mt19937_64 random(2);
  const Eigen::Vector3d beacons[] = {{0, 1, 2.5}, {6, 0, 2.4}, {12, 2, 2.6}, {11, 9, 2.5}, {5, 9.5, 2.45}};
  const Eigen::Vector3d levers[] = {{0.06, 0, 0.3}, {-0.03, 0.05, 0.3}, {-0.03, -0.05, 0.3}};
  const PlanarState truth{4.0, 5.0, 0.7, 0.0};
  const SearchProblem problem = test::search_problem_at(truth, beacons, levers, kSigmaM);
  Consensus consensus(problem);
  const Discord discord = discord_of(problem, consensus);
  const PairPlaces places(problem, consensus, discord, kHeadings);
  const auto pairs = covering_pairs(problem, discord, 3);
  const auto found = places.within(pairs, consensus.score(truth) + 2.0);
  EXPECT_LE(found.size(), pairs.size() + 2);
  EXPECT_GT(places.within(pairs, kNoBound).size(), found.size() + 5);
  for (const PairPlace& place : found)
    EXPECT_LT(std::hypot(place.x_m - truth.x_m, place.y_m - truth.y_m), place.reach_m);
}

}  // namespace pair_places_test
}  // namespace octant
