// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The likelihood of a pose against the mixture as its header states it, written a second time.
#include "models/localizers/least_squares/consensus.h"

#include <random>

#include <gtest/gtest.h>

#include "models/physics/pose.h"
#include "tests/models/localizers/least_squares/search_world.h"

namespace octant {
namespace consensus_test {

constexpr double kSigmaM = 0.01, kSpanM = 15.0;

/// Four beacons, three receivers each, no axes, no bias.
SearchProblem problem_at(const PlanarState& truth, double noise_sigmas, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Eigen::Vector3d beacons[] = {{0, 0, 2.5}, {10, 1, 2.4}, {9, 8, 2.6}, {-1, 7, 2.5}};
  const Eigen::Vector3d levers[] = {{0.3, 0, 0.2}, {-0.2, 0.25, 0.2}, {-0.1, -0.3, 0.3}};
  SearchProblem problem = test::search_problem_at(truth, beacons, levers, kSigmaM);
  for (SearchRange& r : problem.ranges) r.range_m += truth.offset_m + noise_sigmas * kSigmaM * normal(random);
  problem.span_m = kSpanM;
  problem.lever_m = 0.4;
  return problem;
}

double residual_of(const SearchRange& r, const PlanarState& s) {
  const Pose T = Pose::planar(s.x_m, s.y_m, s.heading_rad);
  return r.range_m - s.offset_m - (T * r.p_lever_m - r.p_beacon_map_m).norm();
}

/// Each arrival separately: half its square, limited to the cost of an echo or a spurious one.
double mixture(const SearchProblem& problem, const PlanarState& s, double extra_m) {
  const double sigma = std::hypot(kSigmaM, extra_m);
  const double late = std::log(1.4 * kSpanM / sigma), early = std::log(28.0 * kSpanM / sigma);
  double sum = 0.0;
  for (const SearchRange& r : problem.ranges) {
    const double residual = residual_of(r, s);
    sum += std::min(0.5 * std::pow(residual / sigma, 2), residual > 0 ? late : early);
  }
  return sum;
}

TEST(Consensus, ScoreIsTheMixturesLikelihood) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const PlanarState truth{4.0, 3.0, 0.7, 0.0};
  for (int k = 0; k < 200; ++k) {
    SearchProblem problem = problem_at(truth, 1.0, random);
    if (k % 3 == 1) problem.ranges[static_cast<std::size_t>(k) % 12].range_m += 0.9;  // an echo
    if (k % 3 == 2) problem.ranges[static_cast<std::size_t>(k) % 12].range_m -= 0.9;  // nothing real
    const PlanarState s{truth.x_m + 0.02 * normal(random), truth.y_m + 0.02 * normal(random),
                        truth.heading_rad + 0.05 * normal(random), 0.0};
    Consensus consensus(problem);
    consensus.judge_shadows(false);
    EXPECT_NEAR(consensus.score(s), mixture(problem, s, 0.0), 1e-9) << k;
    consensus.set_extra_sigma(0.05);
    EXPECT_NEAR(consensus.score(s), mixture(problem, s, 0.05), 1e-9) << k;
  }
}

/// All arrivals of one beacon a metre late: it costs a beacon's cap once, not an arrival's three times.
TEST(Consensus, AShadowedBeaconCostsItsCapOnce) {
  std::mt19937_64 random(2);
  const PlanarState truth{4.0, 3.0, 0.7, 0.0};
  SearchProblem problem = problem_at(truth, 0.0, random);
  for (std::size_t i = problem.group_first[2]; i < problem.group_first[3]; ++i)
    problem.ranges[i].range_m += 1.0;
  Consensus consensus(problem);
  const double of_mean = std::log(1.4 * kSpanM / (kSigmaM / std::sqrt(3.0)));
  EXPECT_NEAR(consensus.score(truth), of_mean, 1e-9);
  consensus.judge_shadows(false);
  EXPECT_NEAR(consensus.score(truth), 3 * std::log(1.4 * kSpanM / kSigmaM), 1e-9);
}

/// Four pings received from behind count once, not four times; one at the edge of reception does not count.
TEST(Consensus, HearingFromBehindIsPaidOnceAPath) {
  const Eigen::Vector3d beacons[] = {{5, 0, 2.5}, {0, 5, 2.5}}, levers[] = {{0.1, 0, 0.3}};
  SearchProblem once = test::search_problem_at({0, 0, 0, 0}, beacons, levers, kSigmaM);
  for (SearchRange& r : once.ranges) r.hearing_cosine = 0.5;
  once.ranges[0].axis = {-1, 0};
  SearchProblem often = once;
  often.ranges.insert(often.ranges.begin(), 3, once.ranges[0]);
  often.group_first = {0, 4, 5};
  const double behind = Consensus(once).score({0, 0, 0, 0});
  EXPECT_GT(behind, 1.0);
  EXPECT_NEAR(Consensus(often).score({0, 0, 0, 0}), behind, 1e-9);
  once.ranges[0].axis = {std::cos(1.1), std::sin(1.1)};  // 63 degrees
  EXPECT_NEAR(Consensus(once).score({0, 0, 0, 0}), 0.0, 1e-9);
}

TEST(Consensus, GivesUpAboveTheLimitAndNeverBelow) {
  std::mt19937_64 random(3);
  const SearchProblem problem = problem_at({4.0, 3.0, 0.7, 0.0}, 1.0, random);
  Consensus consensus(problem);
  const PlanarState off{4.3, 3.0, 0.7, 0.0};
  const double whole = consensus.score(off);
  EXPECT_GT(consensus.score(off, 0.5 * whole), 0.5 * whole);
  EXPECT_DOUBLE_EQ(consensus.score(off, 2 * whole), whole);
}

/// An echo of two metres bends least squares by centimetres and leaves the refined pose where it is.
TEST(Consensus, RefinesToTheTruthPastAnEcho) {
  std::mt19937_64 random(4);
  const PlanarState truth{4.0, 3.0, 0.7, 0.0};
  SearchProblem problem = problem_at(truth, 0.0, random);
  problem.ranges[4].range_m += 2.0;
  Consensus consensus(problem);
  PlanarState s{4.05, 2.96, 0.76, 0.0};
  const Eigen::Matrix4d H = consensus.refine(s, 60);
  EXPECT_NEAR(s.x_m, truth.x_m, 1e-3);
  EXPECT_NEAR(s.y_m, truth.y_m, 1e-3);
  EXPECT_NEAR(s.heading_rad, truth.heading_rad, 1e-2);
  // Its information is that of the eleven others: J'J / sigma^2 by central differences.
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < problem.ranges.size(); ++i) {
    if (i == 4) continue;
    Eigen::Vector3d j;
    for (int p = 0; p < 3; ++p) {
      PlanarState ends[2] = {s, s};
      constexpr double kStep = 1e-5;
      for (const int side : {0, 1}) {
        double* const at[] = {&ends[side].x_m, &ends[side].y_m, &ends[side].heading_rad};
        *at[p] += side == 0 ? -kStep : kStep;
      }
      j[p] =
          (residual_of(problem.ranges[i], ends[1]) - residual_of(problem.ranges[i], ends[0])) / (2 * kStep);
    }
    expected += j * j.transpose() / (kSigmaM * kSigmaM);
  }
  EXPECT_LT((H.topLeftCorner<3, 3>() - expected).norm(), 0.01 * expected.norm());
}

TEST(Consensus, BestOffsetIsAMedianThatEchoesDoNotPull) {
  std::mt19937_64 random(5);
  const PlanarState truth{4.0, 3.0, 0.7, 1.25};
  SearchProblem problem = problem_at(truth, 0.0, random);
  problem.has_offset = true;
  for (const std::size_t echo : {0U, 5U, 9U}) problem.ranges[echo].range_m += 3.0;
  Consensus consensus(problem);
  EXPECT_NEAR(consensus.best_offset({4.0, 3.0, 0.7, 0.0}), truth.offset_m, 1e-9);
}

}  // namespace consensus_test
}  // namespace octant
