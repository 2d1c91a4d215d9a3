// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace error_model_test {

using calib::Solution;

/// A hall with a delay per beacon; each pair keeps an error of `sigmas` times the noise for some `stops`
/// stops of `epochs`.
World hall_with_memory(std::uint64_t seed, double sigmas, double stops, int epochs = 200) {
  Scenario s = hall_scenario();
  s.path.epochs = epochs;
  World world = must(simulate(s, seed));
  Random random(seed, 77);
  const double keep = std::exp(-1.0 / stops), fresh = std::sqrt(1 - keep * keep);
  std::map<std::pair<int, int>, std::pair<std::int64_t, double>>
      bias;  // of a pair: the stop it is of, and its value
  for (Arrival& a : world.run.arrivals) {
    auto [at, is_new] = bias.try_emplace({a.beacon.value, a.receiver.value}, a.epoch, random.normal());
    for (; at->second.first < a.epoch; ++at->second.first)
      at->second.second = keep * at->second.second + fresh * random.normal();
    a.tof_s += sigmas * world.site.noise.tof_sigma_s * at->second.second;
  }
  return world;
}

double nees_of(const World& world, const Solution& solution, bool white) {
  Solution s = solution;
  if (white && !s.white_covariance.parameters.empty()) s.covariance = s.white_covariance;
  const BeaconErrors e = beacon_errors(world, s);
  return e.nees() / static_cast<double>(e.error.size());
}

TEST(ErrorModel, SimulatedNoiseIsWhiteAndCostsNothing) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Solution solution = solution_of(must(simulate(hall_scenario(), seed)));
    EXPECT_FALSE(solution.errors.correlated) << "seed " << seed;
    EXPECT_TRUE(solution.white_covariance.parameters.empty());
  }
}

/// A short log shows a memory weakly: the test of whiteness must not be so strict that its sigmas are those
/// of white noise after all.
TEST(ErrorModel, ShortLogsAreNotTakenForWhite) {
  constexpr int kWorlds = 40;
  int seen = 0, alarms = 0;
  double honest = 0.0;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    const World world = hall_with_memory(seed, 1.5, 4.0, 30);
    const Solution solution = solution_of(world);
    seen += solution.errors.correlated ? 1 : 0;
    honest += nees_of(world, solution, false) / kWorlds;
    alarms += solution_of(hall_with_memory(seed, 0.0, 1.0, 30)).errors.correlated ? 1 : 0;
  }
  EXPECT_GE(seen, 18) << "at a significance of one in ten thousand it is seen in 13";
  EXPECT_LE(alarms, 2) << "one in a hundred is to be expected";
  EXPECT_GT(honest, 0.6);
  EXPECT_LT(honest, 1.6);
}

TEST(ErrorModel, SigmasHoldWhereErrorsHaveAMemory) {
  double honest = 0.0, white = 0.0;
  constexpr int kWorlds = 8;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    const World world = hall_with_memory(seed, 3.0, 20.0);
    const Solution solution = solution_of(world);
    ASSERT_TRUE(solution.errors.correlated) << "seed " << seed;
    EXPECT_THAT(solution.warnings, testing::Contains(testing::HasSubstr("errors are correlated")));
    honest += nees_of(world, solution, false) / kWorlds;
    white += nees_of(world, solution, true) / kWorlds;
  }
  // About ten independent segments for each pair: the variances behind the sigmas are known to a third,
  // averaged over eight worlds.
  EXPECT_GT(honest, 0.3);
  EXPECT_LT(honest, 2.5);
  EXPECT_GT(white, 4.0) << "white noise would do: this test tests nothing";
}

TEST(ErrorModel, TheVarianceOfTheErrorsIsFound) {
  const World world = hall_with_memory(3, 3.0, 20.0);
  const Solution solution = solution_of(world);
  const double unit_s = solution.tof_sigma_s, stated_s = world.site.noise.tof_sigma_s;
  const double total_s =
      unit_s * std::sqrt(solution.errors.white_tof + std::pow(solution.errors.correlated_sigma(), 2) +
                         std::pow(solution.errors.pair_sigma(), 2));
  EXPECT_NEAR(total_s / stated_s, std::sqrt(10.0),
              0.6);  // 3 and 1; pairs' own means wander by a fifth in so short a log
}

/// Draws of simulated errors use the covariance's root: results must depend on it, but not on its last digit.
TEST(ErrorModel, StatedSigmasDoNotHangOnRounding) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    World world = hall_with_memory(seed, 3.0, 20.0);
    const Solution before = solution_of(world);
    ASSERT_TRUE(before.errors.correlated) << "seed " << seed;
    for (std::size_t i = 50; i < world.run.arrivals.size(); i += 200)
      world.run.arrivals[i].tof_s *= 1 + 1e-12;
    const Solution after = solution_of(world);
    const Eigen::VectorXd ratio =
        after.covariance.matrix.diagonal().cwiseQuotient(before.covariance.matrix.diagonal());
    // A part in 10^12 of a time is a part in 10^7 of the noise.
    EXPECT_LT((ratio.array() - 1.0).abs().maxCoeff(), 1e-5) << "seed " << seed;
  }
}

}  // namespace error_model_test
}  // namespace octant::test
