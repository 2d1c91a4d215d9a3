// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Failures counted from sums of layers, compared with dense inverses of the remainder.
#include "survey/map/losses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>

#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "survey/geometry/geometry_map.h"
#include "survey/geometry/map_tiles.h"
#include "tests/survey/brute_force.h"

namespace octant::survey {
namespace losses_test {

constexpr double kTolerance_m = 0.03;

SurveyModel scattered(Random& draws, int beacons, double range_m) {
  SurveyModel model;
  model.receivers = {{"r0", {0, 0, 0.3}}};
  model.unknowns = unknowns_of(model.motion, model.clock, model.receivers);
  model.noise.constant_m = 0.01;
  model.hearing.range_m = range_m;
  for (int b = 0; b < beacons; ++b)
    model.beacons.push_back({"B", {draws.uniform(0, 20), draws.uniform(0, 15), draws.uniform(2, 3)}});
  return model;
}

PoseList scattered_poses(Random& draws, std::size_t count) {
  PoseList poses;
  for (std::size_t i = 0; i < count; ++i) poses.add(draws.uniform(0, 20), draws.uniform(0, 15), 0, 0);
  return poses;
}

/// Sigma at a pose without some beacons; kNoFix if the others do not determine it.
double sigma_without(const SurveyModel& model, const PoseList& poses, std::size_t i, std::size_t first,
                     std::size_t second) {
  auto arrivals = test::brute_arrivals(model, poses.x_m[i], poses.y_m[i], poses.z_m[i], 0.0);
  std::erase_if(arrivals, [&](const auto& a) { return a.beacon == first || a.beacon == second; });
  if (static_cast<int>(arrivals.size()) < model.unknowns.count()) return kNoFix;
  const Eigen::MatrixXd C = test::information_of(model, arrivals, true).inverse();
  return std::sqrt(C(0, 0) + C(1, 1));
}

struct Account {
  explicit Account(const SurveyModel& model, const PoseList& poses, int at_once, double other_m2 = 0.0)
      : kernel(kernel_model(model, model.beacons)),
        losses(kernel, at_once),
        one_m(poses.size()),
        two_m(poses.size()),
        one_beacon(poses.size()) {
    auto tile = std::make_unique<KernelTile>();
    fill_tile(kernel, model.walls, poses, 0, poses.size(), *tile);
    const std::vector<double> other(poses.size(), other_m2);
    losses.add(kernel, *tile, {other, kTolerance_m, one_m, two_m, one_beacon});
  }
  KernelModel kernel;
  LossAccount losses;
  std::vector<double> one_m, two_m;
  std::vector<std::int32_t> one_beacon;
};

/// Reference: counts from single sigmas.
Loss counted(const SurveyModel& model, const PoseList& poses, std::size_t a, std::size_t b) {
  Loss loss;
  loss.first = a, loss.second = b;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double before = sigma_without(model, poses, i, Loss::kNone, Loss::kNone),
                 after = sigma_without(model, poses, i, a, b);
    if (std::isinf(before) || after == before) continue;
    if (std::isinf(after))
      ++loss.poses_without_fix;
    else
      loss.worst_sigma_m = std::max(loss.worst_sigma_m, after);
    loss.poses_out += before <= kTolerance_m && after > kTolerance_m;
  }
  return loss;
}

void expect_same(const Loss& found, const Loss& expected) {
  EXPECT_EQ(found.poses_out, expected.poses_out) << found.first << " " << found.second;
  EXPECT_EQ(found.poses_without_fix, expected.poses_without_fix) << found.first << " " << found.second;
  // A sum from which a layer was subtracted has the rounding error of the original, times the condition.
  EXPECT_NEAR(found.worst_sigma_m, expected.worst_sigma_m, 1e-6 * (1e-3 + expected.worst_sigma_m));
}

TEST(Losses, CountsAreThoseOfTheGeometryWithoutTheBeacons) {
  Random draws(20261125);
  for (const double range_m : {6.0, 10.0, 100.0}) {
    const SurveyModel model = scattered(draws, 7, range_m);
    const PoseList poses = scattered_poses(draws, 300);
    const Account account(model, poses, 2);
    const auto singles = account.losses.singles();
    ASSERT_EQ(singles.size(), 7U) << "all of them, those that nobody misses too";
    for (const Loss& loss : singles) {
      EXPECT_EQ(loss.second, Loss::kNone);
      expect_same(loss, counted(model, poses, loss.first, Loss::kNone));
    }
    std::map<std::pair<std::size_t, std::size_t>, Loss> pairs;
    for (const Loss& loss : account.losses.pairs(100)) pairs[{loss.first, loss.second}] = loss;
    for (std::size_t a = 0; a < 7; ++a)
      for (std::size_t b = a + 1; b < 7; ++b) {
        const Loss expected = counted(model, poses, a, b);
        if (pairs.contains({a, b}))
          expect_same(pairs[{a, b}], expected);
        else
          EXPECT_EQ(expected.poses_out + expected.poses_without_fix, 0U) << "pairs that do harm are listed";
      }
  }
}

TEST(Losses, TheWorstAtEachPoseIsTheWorstOfAll) {
  Random draws(5);
  for (const double range_m : {8.0, 100.0}) {
    const SurveyModel model = scattered(draws, 6, range_m);
    const PoseList poses = scattered_poses(draws, 100);
    const Account account(model, poses, 2);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      double one = sigma_without(model, poses, i, Loss::kNone, Loss::kNone), two = one;
      for (std::size_t a = 0; a < 6; ++a) {
        one = std::max(one, sigma_without(model, poses, i, a, Loss::kNone));
        for (std::size_t b = 0; b < 6; ++b) two = std::max(two, sigma_without(model, poses, i, a, b));
      }
      if (std::isinf(one))
        EXPECT_EQ(account.one_m[i], kNoFix);
      else
        EXPECT_NEAR(account.one_m[i] / one, 1.0, 1e-6);
      if (std::isinf(two))
        EXPECT_EQ(account.two_m[i], kNoFix);
      else
        EXPECT_NEAR(account.two_m[i] / two, 1.0, 1e-6);
      if (account.one_beacon[i] >= 0) {
        const auto missed = static_cast<std::size_t>(account.one_beacon[i]);
        const double without = sigma_without(model, poses, i, missed, Loss::kNone);
        EXPECT_TRUE(without == one || std::abs(without / one - 1) < 1e-6) << "the beacon that is missed most";
      }
    }
  }
}

TEST(Losses, TheOrderIsThatOfTheHarm) {
  Random draws(6);
  const SurveyModel model = scattered(draws, 8, 9.0);
  const Account account(model, scattered_poses(draws, 400), 2);
  const auto worse = [](const Loss& a, const Loss& b) {
    return std::tie(a.poses_out, a.poses_without_fix, a.spread_ppm) >=
           std::tie(b.poses_out, b.poses_without_fix, b.spread_ppm);
  };
  for (const auto& losses : {account.losses.singles(), account.losses.pairs(100)})
    for (std::size_t i = 1; i < losses.size(); ++i) EXPECT_TRUE(worse(losses[i - 1], losses[i])) << i;
  EXPECT_EQ(account.losses.pairs(3).size(), 3U);
  EXPECT_EQ(account.losses.pairs(3)[2].first, account.losses.pairs(100)[2].first);
}

TEST(Losses, TilesMayBeTakenByAnybody) {
  Random draws(7);
  const SurveyModel model = scattered(draws, 6, 9.0);
  const PoseList poses = scattered_poses(draws, 200);
  PoseList halves[2];
  for (std::size_t i = 0; i < 200; ++i) halves[i % 2].add(poses.x_m[i], poses.y_m[i], 0, 0);
  Account together(model, halves[0], 2), other(model, halves[1], 2);
  together.losses.merge(other.losses);
  const Account whole(model, poses, 2);
  const auto a = together.losses.pairs(100), b = whole.losses.pairs(100);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(std::pair(a[i].first, a[i].second), std::pair(b[i].first, b[i].second));
    EXPECT_EQ(a[i].poses_out, b[i].poses_out);
    EXPECT_EQ(a[i].spread_ppm, b[i].spread_ppm) << "whole numbers: no order of sums shows";
  }
}

/// Most beacons are received in some corner only; a pair of one that is received and one that is not costs as
/// much as the first.
TEST(Losses, PairsCountWhereOnlyOneOfThemIsHeard) {
  Random draws(10);
  const SurveyModel model = scattered(draws, 9, 7.0);
  PoseList all, corners[4];
  for (std::size_t i = 0; i < 200; ++i) {
    const double x = (i % 2 == 0 ? 0.0 : 16.0) + draws.uniform(0, 4),
                 y = (i / 2 % 2 == 0 ? 0.0 : 11.0) + draws.uniform(0, 4);
    all.add(x, y, 0, 0);
    corners[i % 4].add(x, y, 0, 0);
  }
  Account account(model, corners[0], 2);
  for (const std::size_t k : {1, 2, 3}) account.losses.merge(Account(model, corners[k], 2).losses);
  std::size_t harmful = 0;
  for (const Loss& loss : account.losses.pairs(100)) {
    expect_same(loss, counted(model, all, loss.first, loss.second));
    harmful += loss.poses_without_fix > 0;
  }
  EXPECT_GT(harmful, 8U);
}

TEST(Losses, TheCalibrationsPartCountsAgainstTheToleranceBefore) {
  Random draws(8);
  const SurveyModel model = scattered(draws, 7, 100.0);
  const PoseList poses = scattered_poses(draws, 200);
  // With the tolerance used up no cell was inside, so no cell is lost.
  for (const Loss& loss : Account(model, poses, 1, kTolerance_m * kTolerance_m).losses.singles())
    EXPECT_EQ(loss.poses_out, 0U);
  const auto free = Account(model, poses, 1, 0.0).losses.singles();
  EXPECT_GT(free.front().poses_out, 0U);
}

TEST(Losses, NoneAtOnceIsNoAccount) {
  Random draws(9);
  const Account account(scattered(draws, 5, 100.0), scattered_poses(draws, 20), 0);
  EXPECT_TRUE(account.losses.singles().empty());
  EXPECT_TRUE(account.losses.pairs(10).empty());
}

}  // namespace losses_test
}  // namespace octant::survey
