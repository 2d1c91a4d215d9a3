// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Bounds of a search with a known pose, compared with brute force and with worlds that have two poses.
#include "models/localizers/least_squares/rivals.h"

#include <algorithm>
#include <bit>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "models/physics/pose.h"
#include "tests/models/localizers/least_squares/search_world.h"

namespace octant {
namespace rivals_test {

constexpr double kSigmaM = 0.004;

/// Three receivers receive each of the beacons without noise.
SearchProblem problem_at(const PlanarState& truth, const std::vector<Eigen::Vector3d>& beacons,
                         std::size_t receivers = 3) {
  const Eigen::Vector3d levers[] = {{0.2, 0, 0.3}, {-0.1, 0.15, 0.3}, {-0.1, -0.15, 0.3}};
  return test::search_problem_at(truth, beacons, std::span(levers).first(receivers), kSigmaM);
}

const std::vector<Eigen::Vector3d> kAround = {{0, 1, 2.5},  {6, 0, 2.4},    {12, 2, 2.6},
                                              {11, 9, 2.5}, {5, 9.5, 2.45}, {-0.5, 7, 2.55}};
constexpr PlanarState kTruth{4.0, 5.0, 0.7, 0.0};

bool excludes(const SearchProblem& problem, std::size_t outliers) {
  Consensus consensus(problem);
  return excludes_rivals(problem, consensus, discord_of(problem, consensus), kTruth, outliers);
}

/// Discord of arrivals without contradictions.
Discord no_discord(const SearchProblem& problem) {
  Discord none;
  none.cost.assign(problem.groups(), 0.0);
  none.is_odd.assign(problem.ranges.size(), 0);
  return none;
}

TEST(Rivals, AScoreHoldsNoMoreOutliersThanTheBound) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform;
  for (int k = 0; k < 300; ++k) {
    SearchProblem problem = problem_at(kTruth, kAround);
    std::size_t late = 0, shadowed = 0;
    for (std::size_t b = 0; b < kAround.size(); ++b) {
      // A whole beacon in a shadow counts for one, as does one of its arrivals.
      const double draw = uniform(random);
      late += draw < 0.5;
      shadowed += draw < 0.25;
      for (std::size_t i = 3 * b; i < 3 * b + (draw < 0.25 ? 3 : draw < 0.5 ? 1 : 0); ++i)
        problem.ranges[i].range_m += 1.0;
    }
    Consensus consensus(problem);
    const double score = consensus.score(kTruth);
    EXPECT_EQ(most_outliers(consensus, no_discord(problem), score, 0.0), late) << k;
    // A single one contradicts the other two of its beacon, which every pose pays for.
    EXPECT_EQ(most_outliers(consensus, discord_of(problem, consensus), score, 0.0), shadowed) << k;
  }
}

TEST(Rivals, SixBeaconsAroundHaveNoneWithThreeOutliers) {
  EXPECT_TRUE(excludes(problem_at(kTruth, kAround), 0));
  EXPECT_TRUE(excludes(problem_at(kTruth, kAround), 3));
  EXPECT_FALSE(excludes(problem_at(kTruth, kAround), 4)) << "two beacons have a mirror image";
}

TEST(Rivals, ArrivalsThatDisagreeSpeakForNoPose) {
  SearchProblem problem = problem_at(kTruth, kAround);
  for (std::size_t i = 0; i < 6; ++i) problem.ranges[i].range_m += 0.5;
  EXPECT_TRUE(excludes(problem, 1));
  EXPECT_FALSE(excludes(problem, 2));
}

TEST(Rivals, BeaconsInLineHaveAMirrorImage) {
  std::vector<Eigen::Vector3d> line;
  for (int b = 0; b < 6; ++b) line.emplace_back(2.5 * b, 0.0, 2.5);
  EXPECT_FALSE(excludes(problem_at(kTruth, line), 0));
  line.back().y() = 8.0;
  EXPECT_TRUE(excludes(problem_at(kTruth, line), 0));
  EXPECT_FALSE(excludes(problem_at(kTruth, line), 1)) << "without the one that is not in line";
}

TEST(Rivals, OneReceiverTellsNoHeading) {
  EXPECT_FALSE(excludes(problem_at(kTruth, kAround, 1), 0));
  EXPECT_TRUE(excludes(problem_at(kTruth, kAround, 2), 0));
}

/// Pings over one path repeat one equation.
TEST(Rivals, PathsCountOnce) {
  const std::vector<Eigen::Vector3d> three(kAround.begin(), kAround.begin() + 3);
  SearchProblem problem = problem_at(kTruth, three);
  EXPECT_TRUE(excludes(problem, 0)) << "nine paths";
  for (std::size_t b = 0; b < 3; ++b) problem.ranges[3 * b + 2] = problem.ranges[3 * b + 1];
  EXPECT_FALSE(excludes(problem, 0)) << "six";
}

/// Information of what agrees against the square of numeric derivatives of the ranges.
TEST(Rivals, AgreementIsTheInformationOfWhatAgrees) {
  SearchProblem problem = problem_at(kTruth, kAround);
  problem.ranges[1].range_m += 0.3;
  Consensus consensus(problem);
  Eigen::Matrix3d found = Eigen::Matrix3d::Zero(), expected = found;
  const std::vector<char> none(problem.ranges.size(), 0);
  EXPECT_EQ(consensus.agreement(kTruth, 0, 4.0, none, found), 2U);
  for (const std::size_t i : {0U, 2U}) {
    Eigen::RowVector3d J;
    for (int p = 0; p < 3; ++p) {
      const auto range = [&](double h) {
        const Pose T = Pose::planar(kTruth.x_m + (p == 0 ? h : 0), kTruth.y_m + (p == 1 ? h : 0),
                                    kTruth.heading_rad + (p == 2 ? h : 0));
        return (T * problem.ranges[i].p_lever_m - problem.ranges[i].p_beacon_map_m).norm();
      };
      J[p] = (range(1e-5) - range(-1e-5)) / 2e-5;
    }
    expected += J.transpose() * J / (kSigmaM * kSigmaM);
  }
  EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());  // central differences: 1e-10 over 1e-5
}

TEST(Rivals, HeadingInformationIsTheInverseOfItsVariance) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 20; ++k) {
    Eigen::Matrix<double, 5, 3> J;
    for (double& j : J.reshaped()) j = normal(random);
    const Eigen::Matrix3d A = J.transpose() * J;
    EXPECT_NEAR(heading_information(A) * A.inverse()(2, 2), 1.0, 1e-9);
  }
}

/// A lower bound of the score for any pose.
TEST(Rivals, DiscordIsWhatEveryPosePays) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> normal;
  double most = 0.0;
  for (int k = 0; k < 200; ++k) {
    SearchProblem problem = problem_at(kTruth, kAround);
    for (SearchRange& r : problem.ranges)
      r.range_m += kSigmaM * normal(random) + (uniform(random) < 0.2 ? 1.5 * uniform(random) - 0.4 : 0.0);
    for (double& bias_m : problem.group_bias_m) bias_m = k % 2 == 0 ? 0.0 : 0.01;
    Consensus consensus(problem);
    const double total = discord_of(problem, consensus).total;
    most = std::max(most, total);
    PlanarState best = kTruth;
    consensus.refine(best, 20);
    EXPECT_GE(consensus.score(best), total) << k;
    for (int draw = 0; draw < 20; ++draw)
      EXPECT_GE(consensus.score({12 * uniform(random), 9 * uniform(random), 6.3 * uniform(random), 0.0}),
                total)
          << k;
  }
  EXPECT_GT(most, 20.0) << "three outliers that are seen at once";
}

TEST(Rivals, TheOddOneOfThreeIsKnown) {
  SearchProblem problem = problem_at(kTruth, kAround);
  problem.ranges[4].range_m += 0.8;  // one of three
  problem.ranges[6].range_m += 0.8;  // all of three, each by its own
  problem.ranges[7].range_m += 1.6;
  problem.ranges[9].range_m += 0.8;  // all of three alike
  problem.ranges[10].range_m += 0.8;
  problem.ranges[11].range_m += 0.8;
  const Discord discord = discord_of(problem, Consensus(problem));
  const std::vector<char> odd(discord.is_odd.begin(), discord.is_odd.end());
  EXPECT_EQ(odd, (std::vector<char>{0, 0, 0, 0, 1, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  for (const std::size_t beacon : {0U, 3U, 4U, 5U}) EXPECT_EQ(discord.cost[beacon], 0.0);
  for (const std::size_t beacon : {1U, 2U}) EXPECT_GT(discord.cost[beacon], 5.0);
}

/// Two arrivals that contradict each other: either may be right, so pairs are made with both.
TEST(Rivals, ABeaconWithoutAMajorityIsInPairsTwice) {
  SearchProblem problem = problem_at(kTruth, kAround, 2);
  problem.ranges[0].range_m += 1.0;
  const auto pairs = covering_pairs(problem, discord_of(problem, Consensus(problem)), 4);
  for (const std::size_t i : {0U, 1U})
    EXPECT_TRUE(std::any_of(pairs.begin(), pairs.end(), [i](const auto& pair) { return pair[0] == i; })) << i;
  EXPECT_EQ(pairs.size(), 15U + 5U) << "all pairs, those of the first beacon twice";
}

/// Tries every set of this number of beacons as the ones with outliers.
TEST(Rivals, WhicheverBeaconsTheOutliersAreOfAPairIsWithout) {
  for (std::size_t beacons = 2; beacons <= 9; ++beacons) {
    std::vector<Eigen::Vector3d> places;
    for (std::size_t b = 0; b < beacons; ++b)
      places.emplace_back(9 * std::cos(1.0 * static_cast<double>(b)),
                          9 * std::sin(1.0 * static_cast<double>(b)), 2.0);
    SearchProblem problem = problem_at(kTruth, places);
    for (std::size_t b = 0; b < beacons; ++b) problem.ranges[3 * b + 1].range_m -= 1.0;  // the earliest
    for (std::size_t outliers = 0; outliers + 2 <= beacons; ++outliers) {
      const auto pairs = covering_pairs(problem, no_discord(problem), outliers);
      for (std::size_t bad = 0; bad < (1U << beacons); ++bad) {
        if (static_cast<std::size_t>(std::popcount(bad)) != outliers) continue;
        EXPECT_TRUE(std::any_of(
            pairs.begin(), pairs.end(),
            [&](const auto& pair) { return (bad >> pair[0] / 3 & 1) == 0 && (bad >> pair[1] / 3 & 1) == 0; }))
            << beacons << " " << outliers;
      }
      for (const auto& [i, j] : pairs) {
        EXPECT_EQ(i % 3, 1U);
        EXPECT_EQ(j % 3, 1U);
        EXPECT_NE(i, j);
      }
    }
  }
}

}  // namespace rivals_test
}  // namespace octant
