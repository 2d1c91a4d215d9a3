// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/reception.h"

#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "models/simulator/random.h"

namespace octant::test {
namespace reception_test {

constexpr std::size_t kBeacons = 8;
constexpr double kReach_m = 10.0;

/// Beacons along a wall of 24 m. A vehicle drives along it, beacons fire one after the other, and an arrival
/// comes from those within reach.
/// @param is_received  (beacon, time): true if a firing is received; obstacles and faults
std::vector<Reception> drive(double seconds, double from_m, double to_m,
                             const std::function<bool(std::size_t, double)>& is_received,
                             double reach_m = std::numeric_limits<double>::infinity()) {
  constexpr double kSlot_s = 0.05;
  ReceptionLog log(kBeacons, reach_m);
  for (std::size_t k = 0; static_cast<double>(k) * kSlot_s < seconds; ++k) {
    const double t = static_cast<double>(k) * kSlot_s, x = from_m + (to_m - from_m) * t / seconds;
    std::array<double, kBeacons> distance_m{};
    for (std::size_t b = 0; b < kBeacons; ++b)
      distance_m[b] = std::hypot(x - 24.0 * static_cast<double>(b) / (kBeacons - 1), 2.0);
    const std::size_t b = k % kBeacons;
    if (distance_m[b] < kReach_m && is_received(b, t)) log.add(t, b, distance_m);
  }
  return log.judge(1.0);
}

std::vector<std::size_t> silent(const std::vector<Reception>& receptions) {
  std::vector<std::size_t> found;
  for (std::size_t b = 0; b < receptions.size(); ++b)
    if (receptions[b].is_silent) found.push_back(b);
  return found;
}

bool always(std::size_t, double) { return true; }

TEST(Reception, ExpectationsAgreeWithCountsWhereNothingIsWrong) {
  const auto found = drive(400.0, 2.0, 22.0, always);
  EXPECT_TRUE(silent(found).empty());
  for (const Reception& r : found) {
    EXPECT_GT(r.expected, 0.75 * r.received);  // cautious at the limit of reach
    EXPECT_LT(r.expected, 1.1 * r.received);
  }
}

TEST(Reception, ABeaconOutOfReachIsNotExpected) {
  const auto found = drive(400.0, 1.0, 8.0, always);
  EXPECT_TRUE(silent(found).empty());
  EXPECT_EQ(found[7].received, 0.0);
  EXPECT_EQ(found[7].expected, 0.0);
}

TEST(Reception, ADeadBeaconIsSilentAndNobodyElse) {
  const auto found = drive(200.0, 2.0, 22.0, [](std::size_t b, double) { return b != 3; });
  ASSERT_EQ(silent(found), std::vector<std::size_t>{3});
  EXPECT_FALSE(found[3].silence.is_partial);
  EXPECT_EQ(found[3].silence.received, 0.0);
  EXPECT_NEAR(found[3].silence.expected, drive(200.0, 2.0, 22.0, always)[3].received,
              0.25 * found[3].silence.expected);
}

TEST(Reception, ATenthOfTheArrivalsIsSilent) {
  Random random(5, 1);
  const auto found =
      drive(300.0, 2.0, 22.0, [&](std::size_t b, double) { return b != 5 || random.uniform(0, 1) < 0.1; });
  EXPECT_EQ(silent(found), std::vector<std::size_t>{5});
}

TEST(Reception, ABeaconThatStopsHalfWayIsSilentFromThenOn) {
  const auto found = drive(400.0, 6.0, 18.0, [](std::size_t b, double t) { return b != 4 || t < 200.0; });
  ASSERT_EQ(silent(found), std::vector<std::size_t>{4});
  EXPECT_TRUE(found[4].silence.is_partial);
  EXPECT_GE(found[4].silence.since_s, 150.0);
  EXPECT_LE(found[4].silence.since_s, 260.0);
}

TEST(Reception, AFewSecondsAccuseNobody) {
  Random random(6, 1);
  for (int k = 0; k < 200; ++k) {
    const double from_m = random.uniform(0.0, 24.0);
    EXPECT_TRUE(silent(drive(random.uniform(1.0, 8.0), from_m, from_m + 1.0, [&](std::size_t, double) {
                  return random.uniform(0, 1) < 0.8;
                })).empty());
  }
}

/// Shelves hide each beacon from a part of the path of its own: rates differ, and silence means little.
TEST(Reception, WhereBeaconsAreHiddenForAWhileNobodyIsSilent) {
  const auto found = drive(400.0, 8.0, 16.0, [](std::size_t b, double t) {
    return std::fmod(t + 57.0 * static_cast<double>(b), 300.0) < 130.0;
  });
  EXPECT_TRUE(silent(found).empty());
}

TEST(Reception, OfTheStatedReachNothingIsExpectedBeyond) {
  const auto found = drive(
      400.0, 2.0, 22.0, [](std::size_t b, double) { return b != 3; }, 1.0);
  EXPECT_TRUE(silent(found).empty());
}

/// Receivers of a vehicle have equal distances.
TEST(Reception, AtEqualDistancesTheMeanOfTheOthersIsExpected) {
  ReceptionLog log(4, std::numeric_limits<double>::infinity());
  const std::array<double, 4> distance_m{};
  for (std::size_t k = 0; k < 600; ++k) log.add(static_cast<double>(k), k % 3, distance_m);
  const auto found = log.judge(1.0);
  EXPECT_EQ(silent(found), std::vector<std::size_t>{3});
  EXPECT_NEAR(found[0].expected, 200.0, 1.0);
  EXPECT_NEAR(found[3].expected, 200.0, 1.0);
}

TEST(NegativeBinomial, IsPoissonWithoutVarianceAndHasAClosedFormAtZero) {
  EXPECT_NEAR(negative_binomial_at_most(2, 3.0, 1e-9), std::exp(-3.0) * (1 + 3 + 4.5), 1e-6);
  EXPECT_NEAR(negative_binomial_at_most(0, 10.0, 0.25), std::pow(4.0 / 14.0, 4.0), 1e-12);
  EXPECT_NEAR(negative_binomial_at_most(1e4, 10.0, 0.25), 1.0, 1e-9);
}

}  // namespace reception_test
}  // namespace octant::test
