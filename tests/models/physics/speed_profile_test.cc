// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/speed_profile.h"

#include <cmath>

#include <gtest/gtest.h>

namespace octant {
namespace speed_profile_test {

/// Warm surface, minimum at 800 m, then rising with pressure: a plain ocean.
SpeedProfile ocean() {
  return SpeedProfile({{-3000, 1517}, {-800, 1482}, {-200, 1500}, {-50, 1525}, {0, 1528}});
}

/// Travel time by small straight steps of constant speed, the ray parameter found by bisection: an
/// independent, slow way.
double travel_time_by_steps(const SpeedProfile& profile, double horizontal_m, double low_m, double high_m) {
  constexpr int kSteps = 20'000;
  const double h = (high_m - low_m) / kSteps;
  double fastest = 0.0;
  for (int i = 0; i < kSteps; ++i) fastest = std::max(fastest, profile.speed_at(low_m + (i + 0.5) * h));
  double a = 0.0, b = 1 / fastest, time_s = 0.0;
  for (int round = 0; round < 60; ++round) {
    const double p = 0.5 * (a + b);
    double x = 0.0;
    time_s = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double c = profile.speed_at(low_m + (i + 0.5) * h), s = std::sqrt(1 - p * p * c * c);
      x += h * p * c / s;
      time_s += h / (c * s);
    }
    (x < horizontal_m ? a : b) = p;
  }
  return time_s;
}

TEST(SpeedProfile, IsLinearBetweenItsLevelsAndConstantBeyond) {
  const SpeedProfile p({{-100, 1500}, {0, 1520}});
  EXPECT_DOUBLE_EQ(p.speed_at(-500), 1500);
  EXPECT_DOUBLE_EQ(p.speed_at(-25), 1515);
  EXPECT_DOUBLE_EQ(p.speed_at(12), 1520);
}

TEST(SpeedProfile, ConstantSpeedGivesStraightRays) {
  const SpeedProfile p({{-1000, 1500}, {0, 1500}});
  EXPECT_NEAR(p.travel_time_s(800, -600, 0), 1000.0 / 1500, 1e-12);
  EXPECT_NEAR(p.travel_time_s(0, -600, 0), 600.0 / 1500, 1e-12);
  EXPECT_DOUBLE_EQ(p.mean_speed_mps(-600, 0), 1500);
}

TEST(SpeedProfile, TravelTimesAgreeWithSmallSteps) {
  for (const double horizontal_m : {50.0, 700.0, 2000.0})
    EXPECT_NEAR(ocean().travel_time_s(horizontal_m, -2700, -5),
                travel_time_by_steps(ocean(), horizontal_m, -2700, -5), 2e-9)
        << horizontal_m;
}

TEST(SpeedProfile, TimesDoNotDependOnTheDirection) {
  EXPECT_DOUBLE_EQ(ocean().travel_time_s(900, -2000, -5), ocean().travel_time_s(900, -5, -2000));
}

TEST(SpeedProfile, BentRaysAreFasterThanStraightOnes) {
  // Fermat: the ray is the fastest path. At 45 degrees in 2 km some millimetres to centimetres.
  const double straight_s = std::hypot(2000, 2000) / ocean().mean_speed_mps(-2005, -5);
  const double gain_m = (straight_s - ocean().travel_time_s(2000, -2005, -5)) * 1500;
  EXPECT_GT(gain_m, 0.05);
  EXPECT_LT(gain_m, 5.0);
}

TEST(SpeedProfile, NearlyHorizontalPathsAreStraight) {
  const double t = ocean().travel_time_s(5000, -20, -19);
  EXPECT_NEAR(t, std::hypot(5000, 1) / ocean().mean_speed_mps(-20, -19), 1e-12);
}

TEST(SpeedProfile, EffectiveSpeedHoldsTheCurvatureOfTheEarth) {
  const SpeedProfile p({{-3000, 1500}, {0, 1500}});
  const Eigen::Vector3d ship(1400, 0, 0), beacon(0, 0, -2700);
  const double distance_m = (ship - beacon).norm();
  const double shorter_m = distance_m - 1500 * distance_m / p.effective_speed_mps(ship, beacon);
  EXPECT_NEAR(shorter_m, 1400 * (1350 / 6.371e6) * 1400 / distance_m, 1e-4);
}

TEST(SeaWater, AgreesWithMackenziesCheckValue) {
  EXPECT_NEAR(sea_water_speed_mps(25, 35, 1000), 1550.744, 5e-4);
}

}  // namespace speed_profile_test
}  // namespace octant
