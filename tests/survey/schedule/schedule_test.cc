// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Firing schedule: times of silence against closed forms and a list of image sources, groups against brute
// force.
#include "survey/schedule/schedule.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "models/localizers/kleeman/kleeman_schedule.h"
#include "models/simulator/random.h"

namespace octant::survey {
namespace schedule_test {

/// A box of 12 x 8 x 4 m; amplitudes of Kleeman's prototype.
Reverberance box() {
  Reverberance r;
  r.amplitude_1m_v = 12.5;
  r.threshold_v = 0.2;
  r.absorption_np_per_m = 0.05;
  r.wall_reflection = 0.9;
  r.volume_m3 = 12 * 8 * 4;
  r.surface_m2 = 2 * (12 * 8 + 12 * 4 + 8 * 4);
  r.longest_m = std::sqrt(12.0 * 12 + 8 * 8 + 4 * 4);
  r.speed_mps = 345.0;
  return r;
}

TEST(Schedule, WithoutLossesASingleEchoFadesWithTheDistanceAlone) {
  Reverberance r = box();
  r.absorption_np_per_m = 0.0;
  r.wall_reflection = 1.0 - 1e-12;
  // Eq. 1 with n = 0: V_1m / (V_thresh v); bisection and pow() leave some 1e-9.
  const double free_s = shortest_fire_s({.amplitude_1m_v = 12.5, .threshold_v = 0.2, .speed_mps = 345.0});
  EXPECT_NEAR(fall_silent(r).single_echo_s, free_s, 1e-9);
  EXPECT_NEAR(fall_silent(r).kleeman_s, free_s, 1e-9);
}

TEST(Schedule, KleemansFirstEquationWithItsReflectionsCounted) {
  Reverberance r = box();
  r.absorption_np_per_m = 0.0;
  const FallSilent silent = fall_silent(r);
  const double walls = std::floor(silent.kleeman_s * r.speed_mps / r.longest_m);
  EXPECT_GE(walls, 1.0);
  // n reflections give a time in which n walls at least were met.
  EXPECT_NEAR(silent.kleeman_s, 12.5 * std::pow(0.9, walls) / (0.2 * 345.0), 1e-12);
  EXPECT_NEAR(silent.single_echo_s, silent.kleeman_s, 1e-9);
}

TEST(Schedule, NoImageSourceIsHeardAfterTheBound) {
  // All image sources of a shoebox up to twelve reflections a direction, for several places: exact amplitudes
  // (Allen and Berkley).
  const Reverberance r = box();
  const double bound_s = fall_silent(r).single_echo_s;
  const double size[3] = {12, 8, 4};
  Random draws(4);
  double latest_s = 0.0;
  for (int place = 0; place < 20; ++place) {
    double s[3], x[3];
    for (int i = 0; i < 3; ++i) s[i] = draws.uniform(0, size[i]), x[i] = draws.uniform(0, size[i]);
    for (int a = -12; a <= 12; ++a)
      for (int b = -12; b <= 12; ++b)
        for (int c = -12; c <= 12; ++c) {
          const int n[3] = {a, b, c};
          double d2 = 0.0;
          for (int i = 0; i < 3; ++i) {
            const double image = n[i] % 2 == 0 ? n[i] * size[i] + s[i] : (n[i] + 1) * size[i] - s[i];
            d2 += (image - x[i]) * (image - x[i]);
          }
          const double d = std::sqrt(d2);
          const double amplitude = 12.5 / d * std::exp(-r.absorption_np_per_m * d) *
                                   std::pow(r.wall_reflection, std::abs(a) + std::abs(b) + std::abs(c));
          if (amplitude > r.threshold_v) latest_s = std::max(latest_s, d / r.speed_mps);
        }
  }
  EXPECT_LE(latest_s, bound_s);
  EXPECT_GT(latest_s, 0.5 * bound_s) << "a bound, but not an empty one";
}

TEST(Schedule, EyringsReverberationTime) {
  Reverberance r = box();
  // T60 = 24 ln 10 V / (c (-S ln(1 - a) + 4 m V)), a = 1 - R^2 and m = 2 alpha of energies.
  const double expected_s =
      24 * std::log(10.0) * r.volume_m3 / (345.0 * (-r.surface_m2 * std::log(0.81) + 8 * 0.05 * r.volume_m3));
  EXPECT_NEAR(fall_silent(r).t60_s, expected_s, 1e-12);
  // Sixty decibels: a threshold a thousand times lower is reached one T60 later.
  const double before_s = fall_silent(r).all_echoes_s;
  r.threshold_v /= 1000;
  EXPECT_NEAR(fall_silent(r).all_echoes_s - before_s, expected_s, 1e-12);
}

TEST(Schedule, QuieterHallsHaveShorterSlots) {
  const double slot_s = fall_silent(box()).slot_s;
  for (auto change : std::vector<void (*)(Reverberance&)>{
           [](Reverberance& r) { r.wall_reflection = 0.6; },
           [](Reverberance& r) { r.absorption_np_per_m = 0.15; },
           [](Reverberance& r) { r.threshold_v = 0.5; }, [](Reverberance& r) { r.amplitude_1m_v = 5.0; }}) {
    Reverberance r = box();
    change(r);
    EXPECT_LT(fall_silent(r).slot_s, slot_s);
  }
}

/// Beacons and poses on a line, with a range of 5 m.
Audience line(const std::vector<double>& beacons_m, double length_m) {
  Audience audience;
  for (const double b : beacons_m) {
    audience.heard.emplace_back();
    audience.distance_m.emplace_back();
    for (double x = 0; x <= length_m; x += 0.25) {
      audience.distance_m.back().push_back(std::abs(x - b));
      audience.heard.back().push_back(std::abs(x - b) <= 5.0);
    }
  }
  return audience;
}

TEST(Schedule, BeaconsOutOfEachOthersHearingShareASlot) {
  // 4 m apart, range 5 m: a pose receives beacons up to 10 m from each other, so every third may fire at the
  // same time.
  const FiringPlan plan = share_slots(line({0, 4, 8, 12, 16, 20}, 20), {.reach_m = 5.0}, 0.1);
  EXPECT_EQ(plan.groups, (std::vector<std::vector<std::size_t>>{{0, 3}, {1, 4}, {2, 5}}));
  EXPECT_EQ(plan.least_groups, 3U);
  EXPECT_DOUBLE_EQ(plan.cycle_s(), 0.3);
  EXPECT_DOUBLE_EQ(plan.one_by_one_s(), 0.6);
  EXPECT_EQ(plan.between(0, 3), Sharing::kNeverBoth);
  EXPECT_EQ(plan.between(0, 2), Sharing::kConfused);
}

TEST(Schedule, WallsCountOnlyWhenTrusted) {
  Audience audience = line({0, 4}, 4);
  std::fill(audience.heard[1].begin(), audience.heard[1].end(), 0);  // behind a wall
  EXPECT_EQ(share_slots(audience, {.reach_m = 5.0}, 0.1).groups.size(), 2U)
      << "its echo may come round the wall";
  EXPECT_EQ(share_slots(audience, {.reach_m = 5.0, .trust_walls = true}, 0.1).groups.size(), 1U);
}

TEST(Schedule, TimesThatAreApartCountOnlyWhenAsked) {
  // A room at 0 to 2 m: one beacon at its end, one 30 m further on; both are received, 80 ms apart.
  Audience audience = line({0, 32}, 2);
  std::fill(audience.heard[1].begin(), audience.heard[1].end(), 1);
  EXPECT_EQ(share_slots(audience, {.reach_m = 40.0}, 0.1).between(0, 1), Sharing::kConfused);
  EXPECT_EQ(share_slots(audience, {.reach_m = 40.0, .by_time = true, .guard_s = 0.05}, 0.1).between(0, 1),
            Sharing::kApartInTime);
  EXPECT_EQ(share_slots(audience, {.reach_m = 40.0, .by_time = true, .guard_s = 0.09}, 0.1).between(0, 1),
            Sharing::kConfused);
}

TEST(Schedule, GroupsAreSoundAndNeverFewerThanAClique) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Random draws(seed);
    std::vector<double> places;
    for (int i = 0; i < 14; ++i) places.push_back(draws.uniform(0, 60));
    const Audience audience = line(places, 60);
    const FiringPlan plan = share_slots(audience, {.reach_m = 5.0}, 0.05);
    std::vector<int> seen(places.size(), 0);
    for (const auto& group : plan.groups)
      for (const std::size_t a : group) {
        ++seen[a];
        for (const std::size_t b : group)
          for (std::size_t i = 0; a != b && i < audience.heard[a].size(); ++i)
            ASSERT_FALSE(audience.heard[a][i] && audience.heard[b][i]);
      }
    EXPECT_EQ(seen, std::vector<int>(places.size(), 1));
    // Intervals on a line: their graph is perfect, so the size of the largest clique is the number of groups.
    EXPECT_GE(plan.groups.size(), plan.least_groups);
    std::size_t most = 0;
    for (std::size_t i = 0; i < audience.heard[0].size(); ++i) {
      std::size_t here = 0;
      for (const auto& row : audience.heard) here += row[i];
      most = std::max(most, here);
    }
    EXPECT_GE(plan.groups.size(), most);
    EXPECT_LE(plan.groups.size(), most + 1) << "DSATUR is greedy, but seldom worse by more than one here";
  }
}

}  // namespace schedule_test
}  // namespace octant::survey
