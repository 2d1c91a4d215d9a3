// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_longsolve.h"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/models/localizers/kleeman_room.h"

namespace octant {
namespace kleeman_longsolve_test {

constexpr double kSigma_m = 3.45e-3;  // 10 us

struct Room {
  std::vector<PlanBeacon> plan;
  std::vector<Eigen::Vector3d> in_space;
};

/// Any number of beacons round the walls of a 10 x 10 m room, `height_m` above the receivers.
Room ring(int beacons, double height_m = 1.7) {
  Room room;
  for (int i = 0; i < beacons; ++i) {
    const double s = 40.0 * i / beacons;
    const Eigen::Vector2d p = s < 10   ? Eigen::Vector2d(s, 0)
                              : s < 20 ? Eigen::Vector2d(10, s - 10)
                              : s < 30 ? Eigen::Vector2d(30 - s, 10)
                                       : Eigen::Vector2d(0, 40 - s);
    room.plan.push_back({p, height_m + 0.1 * (i % 3)});
    room.in_space.emplace_back(p.x(), p.y(), room.plan.back().height_m);
  }
  return room;
}

OffsetDistances from(const Room& room, const Eigen::Vector2d& p, double offset_m = 4.0) {
  OffsetDistances d;
  for (std::size_t b = 0; b < room.plan.size(); ++b) {
    d.heard.set(b);
    d.distance_m[b] = slant_distance_m(room.plan[b], p) + offset_m;
    d.sigma_m[b] = kSigma_m;
  }
  return d;
}

LongsolveFix solve(const Room& room, const OffsetDistances& d, const LongsolveOptions& options = {}) {
  const Longsolve longsolve(room.plan, options);
  LongsolveMemory memory = longsolve.memory();
  return longsolve.solve(d, d.heard, 0.0, memory);
}

TEST(TriangleViolations, TheLongerOfTwoIsRejected) {
  const Room room = ring(6);
  OffsetDistances d = from(room, {3, 4});
  EXPECT_TRUE(triangle_violations(d, room.in_space, 4.0).none());
  d.distance_m[2] += 15.0;  // b0 to b2 is some 13 m: eq. 5 fails whatever the place
  EXPECT_EQ(triangle_violations(d, room.in_space, 4.0), BeaconSet().set(2));
  d.heard.reset(2);
  EXPECT_TRUE(triangle_violations(d, room.in_space, 4.0).none()) << "what was not heard is not compared";
}

TEST(TriangleViolations, NoiseIsTolerated) {
  const Room room = ring(4, 0.0);
  OffsetDistances d =
      from(room, {0, 0});  // on beacon 0: the inequality is an equality for every pair with it
  d.distance_m[1] += 3 * std::sqrt(2.0) * kSigma_m;
  EXPECT_TRUE(triangle_violations(d, room.in_space, 4.0).none());
  EXPECT_TRUE(triangle_violations(d, room.in_space, 2.0)[1]);
}

/// The paper's argument: late data never reject good data, so they may go on rejecting.
TEST(TriangleViolations, LateDistancesRejectOnlyLateOnes) {
  Random random(5);
  int rejected = 0;
  for (int k = 0; k < 500; ++k) {
    const Room room = ring(8);
    OffsetDistances d = from(room, {random.uniform(0, 10), random.uniform(0, 10)});
    BeaconSet late;
    for (std::size_t b = 0; b < 8; ++b) {
      if (random.uniform() > 0.4) continue;
      late.set(b);
      d.distance_m[b] += random.uniform(0.0, 20.0);
    }
    const BeaconSet out = triangle_violations(d, room.in_space, 4.0);
    EXPECT_TRUE((out & ~late).none()) << k;
    rejected += static_cast<int>(out.count());
  }
  EXPECT_GT(rejected, 500);
}

TEST(Longsolve, AnyNumberOfBeacons) {
  for (int n = 3; n <= 16; ++n) {
    const Room room = ring(n);
    const Eigen::Vector2d p(4.1, 5.3);
    const LongsolveFix fix = solve(room, from(room, p));
    ASSERT_TRUE(fix.ok()) << n << " " << to_string(fix.status);
    EXPECT_LT((fix.p_map_m - p).norm(), 1e-6) << n;
    EXPECT_NEAR(fix.offset_m, 4.0, 1e-6) << n;
    EXPECT_EQ(fix.triples, n == 3 ? 1 : n == 4 ? 4 : 7) << n;
  }
}

/// "In the average use each beacon distance measurement a preset maximum number of times".
TEST(Longsolve, UsesOfABeaconAreLimited) {
  const Room room = ring(6);
  const OffsetDistances d = from(room, {4.1, 5.3});
  EXPECT_EQ(solve(room, d).triples, 7);  // 21 uses, 5 each at most: five beacons at least
  EXPECT_GE(solve(room, d).averaged.count(), 5u);
  const LongsolveFix once = solve(room, d, {.max_uses = 1});
  ASSERT_TRUE(once.ok());
  EXPECT_EQ(once.triples, 2);  // six beacons, three a triple
  EXPECT_EQ(once.averaged.count(), 6u);
}

/// The gain determines the covariance: derivatives of the average by the distances.
TEST(Longsolve, GainIsTheDerivative) {
  const Room room = ring(6);
  const Eigen::Vector2d p(2.7, 6.1);
  const Longsolve longsolve(room.plan, {});
  const OffsetDistances d = from(room, p);
  LongsolveMemory memory = longsolve.memory();
  const LongsolveFix fix = longsolve.solve(d, d.heard, 0.0, memory);
  ASSERT_TRUE(fix.ok());
  for (int b = 0; b < 6; ++b) {
    Eigen::Vector2d ends[2];
    for (int side = 0; side < 2; ++side) {
      OffsetDistances moved = d;
      moved.distance_m[static_cast<std::size_t>(b)] += side == 0 ? 1e-4 : -1e-4;
      LongsolveMemory same = memory;
      ends[side] = longsolve.solve(moved, d.heard, 0.0, same).p_map_m;
    }
    // The iteration ends within 1e-7 m, a thousandth of the step; curvature is third order.
    EXPECT_LT(((ends[0] - ends[1]) / 2e-4 - fix.gain.col(b)).norm(), 2e-3) << b;
  }
  EXPECT_LT(fix.gain.rowwise().sum().norm(), 1e-9);
}

TEST(Longsolve, OneLateBeaconIsOutvoted) {
  Random random(6);
  for (int k = 0; k < 300; ++k) {
    const Room room = ring(6);
    const Eigen::Vector2d p(random.uniform(1, 9), random.uniform(1, 9));
    OffsetDistances d = from(room, p);
    for (double& m : d.distance_m) m += kSigma_m * random.normal();
    const auto late = static_cast<std::size_t>(k % 6);
    d.distance_m[late] += random.log_uniform(0.2, 4.0);
    const LongsolveFix fix = solve(room, d);
    if (!fix.ok()) continue;  // counted in kleeman_test.cc
    EXPECT_FALSE(fix.averaged[late]) << k;
    EXPECT_TRUE(fix.late[late]) << k;
    const double sigma_m = kSigma_m * fix.gain.norm();
    EXPECT_LT((fix.p_map_m - p).norm(), 5 * sigma_m) << k;
  }
}

/// Step 4 alone, as published: triples with a late beacon are replaced by the next best until the rest agree.
/// (If the late beacon is in most of the best triples, they outvote the others; the exclusions handle that
/// case.)
TEST(Longsolve, RemovalAloneFindsMostOfTheLateBeacons) {
  Random random(9);
  LongsolveOptions published;
  published.max_exclusions = 0;
  LongsolveOptions without = published;
  without.min_triples = without.triples;  // nothing to remove
  int found = 0, found_without = 0;
  for (int k = 0; k < 300; ++k) {
    const Room room = ring(6);
    const Eigen::Vector2d p(random.uniform(1, 9), random.uniform(1, 9));
    OffsetDistances d = from(room, p);
    for (double& m : d.distance_m) m += kSigma_m * random.normal();
    d.distance_m[static_cast<std::size_t>(k % 6)] += random.log_uniform(0.2, 4.0);
    found += solve(room, d, published).ok() ? 1 : 0;
    found_without += solve(room, d, without).ok() ? 1 : 0;
  }
  std::cout << found << " of 300 with removal, " << found_without << " without\n";
  EXPECT_GT(found, 150);
  EXPECT_LT(found_without, 100);
}

/// Step 2: errors are those of the place where they were last computed, until the vehicle is a metre away.
TEST(Longsolve, ErrorsAreRecomputedAfterAMetre) {
  const Room room = ring(6);
  const Longsolve longsolve(room.plan, {});
  LongsolveMemory memory = longsolve.memory();
  const auto go = [&](const Eigen::Vector2d& p) {
    const OffsetDistances d = from(room, p);
    EXPECT_TRUE(longsolve.solve(d, d.heard, 0.0, memory).ok());
    return memory.errors_at_map_m;
  };
  const Eigen::Vector2d first = go({3.0, 3.0});
  EXPECT_LT((first - Eigen::Vector2d(3, 3)).norm(), 1e-6);
  EXPECT_EQ(go({3.6, 3.6}), first);  // 0.85 m
  EXPECT_NE(go({3.8, 3.8}), first);  // 1.13 m
}

/// An inaccurate arrival determines no position, but still contradicts impossible ones.
TEST(Longsolve, RoughDistancesCheckAndDoNotPlace) {
  Random random(10);
  double squares = 0.0, squares_all = 0.0;
  int elsewhere = 0;
  for (int k = 0; k < 200; ++k) {
    const Room room = ring(6);
    const Eigen::Vector2d p{random.uniform(1, 9), random.uniform(1, 9)};  // braces: drawn in this order
    const auto rough = static_cast<std::size_t>(k % 6);
    OffsetDistances d = from(room, p);
    for (std::size_t b = 0; b < 6; ++b) d.distance_m[b] += kSigma_m * random.normal();
    d.distance_m[rough] += 30 * kSigma_m * random.normal();
    d.sigma_m[rough] = 30 * kSigma_m;
    const LongsolveFix all = solve(room, d);
    d.rough.set(rough);
    const LongsolveFix fix = solve(room, d);
    ASSERT_TRUE(fix.ok()) << k;
    EXPECT_FALSE(fix.averaged[rough]) << k;
    EXPECT_TRUE(fix.agreeing[rough]) << k;
    squares += (fix.p_map_m - p).squaredNorm();
    if (all.ok()) squares_all += (all.p_map_m - p).squaredNorm();
    d.distance_m[rough] += 1.0 + 10 * 30 * kSigma_m;  // late
    const LongsolveFix late = solve(room, d);
    ASSERT_TRUE(late.ok()) << k;
    EXPECT_TRUE(late.late[rough]) << k;
    OffsetDistances two = d;  // and another: four of five would do, four of six do not
    two.distance_m[(rough + 1) % 6] += 2.0;
    elsewhere += solve(room, two).ok();
    d.distance_m[rough] -=
        2 * (1.0 + 10 * 30 * kSigma_m);  // no pulse comes early: the others are wrong, or nobody knows
    EXPECT_FALSE(solve(room, d).ok()) << k;
  }
  EXPECT_LT(9 * squares, squares_all) << "a third of the error";
  EXPECT_LE(elsewhere, 2) << "now and then a place elsewhere agrees with five by chance";
}

TEST(Longsolve, SaysWhyThereIsNoFix) {
  const Room room = ring(6);
  OffsetDistances two = from(room, {4, 5});
  two.heard = BeaconSet(0b000011);
  EXPECT_EQ(solve(room, two).status, FixStatus::kTooFewArrivals);

  Room line;
  for (int i = 0; i < 6; ++i) line.plan.push_back({{2.0 * i, 0.0}, 1.5});
  const LongsolveFix mirrored = solve(line, from(line, {4.2, 3.0}));
  EXPECT_EQ(mirrored.status, FixStatus::kAmbiguous);

  OffsetDistances late = from(room, {4, 5});
  const double lateness_m[6] = {3.1, 0.4, 1.7, 5.2, 0.9, 2.3};
  for (std::size_t b = 0; b < 6; ++b) late.distance_m[b] += lateness_m[b];
  EXPECT_EQ(solve(room, late).status, FixStatus::kNoConsensus);

  // Three of four received beacons agree, as any three do, which is no consensus. Three of three are all
  // there are.
  OffsetDistances four = from(room, {4, 5});
  four.heard = BeaconSet(0b010111);
  four.distance_m[1] += 0.5;
  EXPECT_EQ(solve(room, four).status, FixStatus::kNoConsensus);
}

/// Two hyperbolas may meet twice. Inside a triangle of beacons they do not, or the other position is well
/// outside. From outside, the two are indistinguishable.
TEST(Longsolve, ThreeBeaconsMayBeAmbiguous) {
  Random random(8);
  Room room;
  room.plan = {{{4, 4}, 0.0}, {{6, 4}, 0.0}, {{5, 6}, 0.0}};
  int ambiguous = 0, wrong = 0, inside = 0;
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector2d p(random.uniform(0.2, 9.8), random.uniform(0.2, 9.8));
    LongsolveOptions options;
    options.max_sigma_m = 10.0;  // far from so small a triangle everything is vague
    const LongsolveFix fix = solve(room, from(room, p), options);
    if (fix.status == FixStatus::kAmbiguous) ++ambiguous;
    const bool near = (p - p.cwiseMax(4.0).cwiseMin(6.0)).norm() <
                      1.0;  // farther from the beacons' box it is said not to be
    // If they are close to each other, they are one position with a correspondingly large sigma.
    if (near && fix.ok() && (fix.p_map_m - p).norm() > 1e-3 + 3.5 * kSigma_m * fix.gain.norm()) ++wrong;
    const LongsolveFix middle =
        solve(room, from(room, {random.uniform(4.6, 5.4), random.uniform(4.2, 4.8)}), options);
    inside += middle.ok() ? 1 : 0;
  }
  EXPECT_GT(ambiguous, 50);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(inside, 300);
}

}  // namespace kleeman_longsolve_test
}  // namespace octant
