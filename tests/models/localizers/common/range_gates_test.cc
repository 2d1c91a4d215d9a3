// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/range_gates.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "models/localizers/common/arrival_range.h"
#include "models/localizers/common/pair_ranges.h"
#include "tests/models/localizers/ranging_support.h"

namespace octant {
namespace range_gates_test {

constexpr double kSpeed = 340.0;
constexpr RangeGates kGates{.min_m = 0.5, .max_m = 8.0};

GatedArrival signal(int beacon, double range_m, double fired_s = 0.0, int receiver = 0) {
  return {BeaconId(beacon), ReceiverId(receiver), fired_s + range_m / kSpeed, range_m};
}

std::vector<Rejection> judge(const std::vector<GatedArrival>& arrivals) {
  std::vector<Rejection> out(arrivals.size(), Rejection::kUsed);
  apply_range_gates(arrivals, kGates, kSpeed, out);
  return out;
}

constexpr Rejection kUsed = Rejection::kUsed, kOut = Rejection::kOutOfRange, kEcho = Rejection::kReflection;

TEST(RangeGates, WhatIsNearerOrFartherThanPossibleIsDiscarded) {
  EXPECT_EQ(judge({signal(0, 0.49), signal(1, 0.51), signal(2, 7.99), signal(3, 8.01)}),
            (std::vector{kOut, kUsed, kUsed, kOut}));
  EXPECT_EQ(judge({signal(0, std::nan(""))}), std::vector{kOut});
}

TEST(RangeGates, TheLaterOfTwoSignalsThatAreCloseIsAReflection) {
  EXPECT_EQ(judge({signal(0, 3.0), signal(0, 3.4), signal(1, 3.45)}), (std::vector{kUsed, kEcho, kUsed}));
  EXPECT_EQ(judge({signal(0, 3.0), signal(0, 3.51)}), (std::vector{kUsed, kUsed})) << "not closer than d_min";
  EXPECT_EQ(judge({signal(0, 3.0), signal(0, 3.2, 0.0, 1)}), (std::vector{kUsed, kUsed}))
      << "another receiver";
}

TEST(RangeGates, ATrainOfEchoesGoesAsAWhole) {
  EXPECT_EQ(judge({signal(0, 3.0), signal(0, 3.4), signal(0, 3.8), signal(0, 4.2)}),
            (std::vector{kUsed, kEcho, kEcho, kEcho}));
}

TEST(RangeGates, ASpuriousSignalOutOfRangeStartsNoTrain) {
  EXPECT_EQ(judge({signal(0, 0.4), signal(0, 0.8)}), (std::vector{kOut, kUsed}));
}

TEST(RangeGates, ASecondFiringIsNoReflection) {
  // An equal distance 50 ms later: 17 m behind.
  EXPECT_EQ(judge({signal(0, 3.0), signal(0, 3.0, 0.05), signal(0, 3.3, 0.05)}),
            (std::vector{kUsed, kUsed, kEcho}));
}

TEST(RangeGates, RowsOfOneInstantAreToldApartByDistance) {
  std::vector<GatedArrival> arrivals = {signal(0, 3.3), signal(0, 3.0), signal(0, 3.0), signal(1, 3.1)};
  for (GatedArrival& a : arrivals) a.heard_s = 5.0;
  EXPECT_EQ(judge(arrivals), (std::vector{kEcho, kUsed, kUsed, kUsed}));
}

TEST(RangeGates, WithoutLimitsEverythingPasses) {
  const std::vector<GatedArrival> arrivals = {signal(0, 0.01), signal(0, 0.02), signal(0, 900)};
  std::vector<Rejection> out(3, kUsed);
  apply_range_gates(arrivals, {}, kSpeed, out);
  EXPECT_EQ(out, (std::vector{kUsed, kUsed, kUsed}));
}

TEST(RangeGates, WhatWasLeftOutBeforeStaysSo) {
  const std::vector<GatedArrival> arrivals = {signal(0, 3.0), signal(0, 3.2)};
  std::vector<Rejection> out = {Rejection::kBeaconUnusable, kUsed};
  apply_range_gates(arrivals, kGates, kSpeed, out);
  EXPECT_EQ(out, (std::vector{Rejection::kBeaconUnusable, kUsed}));
}

TEST(ArrivalRange, TakesDelaysSpeedAndTemperatureOut) {
  Deployment d = test::ranging_site({{0, 0, 1}}, {{0, 0, 1}});
  d.medium = {.model = MediumModel::kLinearTemperature, .temperature_degC = 20.0};
  d.beacons[0].delay_s = 2e-4;
  d.receivers[0].delay_s = 1e-4;
  d.speed_offset_mps = 0.5;
  Arrival a{.tof_s = 0.0103, .beacon = BeaconId(0), .receiver = ReceiverId(0), .vehicle = VehicleId(0)};
  EXPECT_NEAR(arrival_range(a, d).range_m, (331.3 + 0.606 * 20 + 0.5) * 0.01, 1e-14);  // eq. 1-3
  a.temperature_degC = 30.0;
  EXPECT_NEAR(arrival_range(a, d).range_m, (331.3 + 0.606 * 30 + 0.5) * 0.01, 1e-14);
  d.timing = {.ranging = Ranging::kTwoWay, .turnaround_s = 0.001, .delay_per = {}};
  EXPECT_NEAR(arrival_range(a, d).range_m, (331.3 + 0.606 * 30 + 0.5) * 0.0045, 1e-14);
  a.tof_s = 1e-4;
  EXPECT_TRUE(std::isnan(arrival_range(a, d).range_m)) << "shorter than its delays";
}

TEST(ArrivalRange, TakesTimeWalkOutAtAnyDistance) {
  Deployment d = test::ranging_site({{0, 0, 0}}, {{0, 0, 0}});
  d.attenuation = AttenuationModel{12.5, 0.12, 0.05, 4.5e-4};
  std::mt19937_64 random(1);
  for (double distance_m = 0.05; distance_m < 16.5;
       distance_m += 0.05) {  // 0.995 of the threshold's reach is 16.6 m
    std::vector<Arrival> a = test::hear(d, Pose::planar(distance_m, 0, 0), {.range_m = 100}, random);
    const ArrivalRange range = arrival_range(a.at(0), d);
    EXPECT_NEAR(range.range_m, distance_m, 1e-12) << distance_m;
    const double step_s = 1e-9;
    a[0].tof_s += step_s;
    // Rounding of the difference, 1e-15 m over 1e-9 s, and curvature near the threshold.
    EXPECT_NEAR((arrival_range(a[0], d).range_m - range.range_m) / step_s, range.gain_mps, 1e-3)
        << distance_m;
    a[0].tof_s -= step_s;
    a[0].amplitude_v = amplitude_v(distance_m, *d.attenuation);
    EXPECT_NEAR(arrival_range(a[0], d).range_m, distance_m, 1e-12) << "from the measured amplitude";
  }
}

TEST(ArrivalRange, OffADirectionalReceiversAxisItIsKnownLessWell) {
  Deployment d = test::ranging_site({{0, 0, 0}}, {{0, 0, 0}});
  d.attenuation = AttenuationModel{12.5, 0.12, 0.05, 4.5e-4};
  std::mt19937_64 random(1);
  std::vector<Arrival> a = test::hear(d, Pose::planar(9, 0, 0), {.range_m = 100}, random);
  const double all_round_m = arrival_range(a.at(0), d).sigma_m;
  d.attenuation->half_power_angle_rad = 0.4;
  EXPECT_EQ(arrival_range(a[0], d).sigma_m, all_round_m) << "no axis";
  d.receivers[0].axis = Eigen::Vector3d::UnitX();
  const double walk_m = 343 * (*time_walk_s(amplitude_v(9, *d.attenuation) / std::sqrt(2.0), *d.attenuation) -
                               *time_walk_s(amplitude_v(9, *d.attenuation), *d.attenuation));
  EXPECT_NEAR(arrival_range(a[0], d).sigma_m, std::hypot(all_round_m, walk_m), 0.05 * walk_m);
  // The measured amplitude determines the walk, for any direction; a saturated one does not.
  a[0].amplitude_v = amplitude_v(9, *d.attenuation);
  const double measured_m = arrival_range(a[0], d).sigma_m;
  EXPECT_LT(measured_m, 0.5 * walk_m);
  d.attenuation->saturation_v = a[0].amplitude_v;
  EXPECT_GT(arrival_range(a[0], d).sigma_m, 1.5 * measured_m);
}

TEST(PairRanges, AllocatesNothingAndKeepsTheOrderOfReasons) {
  Deployment d = test::ranging_site({{0, 0, 1}, {4, 0, 1}}, {{0, 0, 1}, {0.2, 0, 1}});
  d.beacons[1].status = BeaconStatus::kUndetermined;
  std::mt19937_64 random(1);
  std::vector<Arrival> a = test::hear(d, Pose::planar(2, 2, 0), {}, random);
  a.push_back(a[0]);
  a.back().vehicle = VehicleId(1);
  PairRanges pairs(d);
  std::vector<Rejection> rejections;
  EXPECT_EQ(pairs.collect(a, d, rejections).size(), 2u);
  EXPECT_EQ(rejections, (std::vector{kUsed, kUsed, Rejection::kBeaconUnusable, Rejection::kBeaconUnusable,
                                     Rejection::kNoPose}));
}

}  // namespace range_gates_test
}  // namespace octant
