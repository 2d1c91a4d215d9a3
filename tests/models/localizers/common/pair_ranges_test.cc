// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/pair_ranges.h"

#include <gtest/gtest.h>

#include "tests/models/localizers/ranging_support.h"

namespace octant::test {
namespace pair_ranges_test {

constexpr double kC = 343.7, kPairNoise_s = 1e-5;

Deployment three_beacons() {
  Deployment d = ranging_site({{0, 0, 2}, {10, 0, 2}, {0, 10, 2}}, {{0.1, 0, 0.3}, {-0.1, 0, 0.3}});
  for (DeploymentBeacon& b : d.beacons) b.delay_s = 0.0;
  return d;
}

Arrival at(std::size_t beacon, std::size_t receiver, double range_m, double time_s) {
  Arrival a;
  a.beacon = BeaconId(beacon);
  a.receiver = ReceiverId(receiver);
  a.vehicle = VehicleId(0);
  a.tof_s = range_m / kC;
  a.time_s = time_s;
  return a;
}

TEST(PairRanges, AreTheMeansOfTheTimesThatAgree) {
  Deployment d = three_beacons();
  d.noise.pair_sigma_s = 2e-5;
  PairRanges ranges(d);
  // Beacon 1 at receiver 0: 5.000, 5.002, and an echo; the others once, out of order.
  const std::vector<Arrival> arrivals = {at(2, 1, 7.0, 0.0),   at(1, 0, 5.0, 0.1), at(1, 0, 5.5, 0.2),
                                         at(1, 0, 5.002, 0.3), at(0, 1, 4.0, 0.4), at(0, 0, 4.1, 0.5)};
  std::vector<Rejection> why;
  const auto pairs = ranges.collect(arrivals, d, why);
  ASSERT_EQ(pairs.size(), 4u);
  const std::vector<std::pair<int, int>> order = {{0, 0}, {0, 1}, {1, 0}, {2, 1}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(pairs[i].beacon.value, order[i].first);
    EXPECT_EQ(pairs[i].receiver.value, order[i].second);
  }
  EXPECT_NEAR(pairs[2].range_m, 5.001, 1e-12);
  EXPECT_EQ(pairs[2].arrivals, 2);
  // The mean of two has a root of two less noise; the bias that the pair keeps stays.
  EXPECT_NEAR(pairs[2].sigma_m, kC * std::hypot(kPairNoise_s / std::sqrt(2.0), 2e-5), 1e-9);
  EXPECT_NEAR(pairs[3].sigma_m, kC * std::hypot(kPairNoise_s, 2e-5), 1e-9);
  EXPECT_NEAR(pairs[2].gain_mps, kC, 1e-9);
  EXPECT_NEAR(pairs[2].by_speed_s, 5.001 / kC, 1e-12);
  for (std::size_t i = 0; i < why.size(); ++i)
    EXPECT_EQ(why[i], i == 2 ? Rejection::kOutvoted : Rejection::kUsed) << i;
}

TEST(PairRanges, SayWhyAnArrivalTakesNoPart) {
  Deployment d = three_beacons();
  d.beacons[2].status = BeaconStatus::kUndetermined;
  PairRanges ranges(d, {.gates = {.min_m = 1.0, .max_m = 20.0}});
  std::vector<Arrival> arrivals = {at(0, 0, 4.0, 0.0), at(2, 0, 4.0, 0.1), at(1, 0, 25.0, 0.2),
                                   at(1, 1, 6.0, 0.3), at(1, 1, 6.0, 0.4)};
  arrivals[3].vehicle = VehicleId(1);
  std::vector<Rejection> why;
  const auto pairs = ranges.collect(arrivals, d, why);
  EXPECT_EQ(pairs.size(), 2u);
  EXPECT_EQ(why, (std::vector<Rejection>{Rejection::kUsed, Rejection::kBeaconUnusable, Rejection::kOutOfRange,
                                         Rejection::kNoPose, Rejection::kUsed}));
  reject_pair(arrivals, pairs[0], Rejection::kLate, why);
  EXPECT_EQ(why[0], Rejection::kLate);
  EXPECT_EQ(why[4], Rejection::kUsed);
}

TEST(PairRanges, AFixBeginsBlankAndEndsCounted) {
  std::vector<Arrival> arrivals = {at(0, 0, 4.0, 1.0), at(1, 0, 4.0, 2.0), at(2, 0, 4.0, 3.0)};
  arrivals[0].epoch = 7;
  Fix fix;
  fix.protection_level_m = fix.cost = 3.0;
  begin_fix(std::span<const Arrival>(arrivals), fix);
  EXPECT_EQ(fix.time_s, 2.0);
  EXPECT_EQ(fix.epoch, 7);
  EXPECT_EQ(fix.vehicle, VehicleId(0));
  EXPECT_EQ(fix.protection_level_m + fix.cost, 0.0);
  fix.rejections = {Rejection::kUsed, Rejection::kLate, Rejection::kUsed};
  end_fix(FixStatus::kOk, fix);
  EXPECT_EQ(fix.arrivals_used, 2);
  EXPECT_EQ(fix.arrivals_rejected, 1);
  end_fix(FixStatus::kAmbiguous, fix);
  EXPECT_TRUE(fix.rejections.empty());
}

}  // namespace pair_ranges_test
}  // namespace octant::test
