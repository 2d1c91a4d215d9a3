// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Accuracy of the speed of sound from a few cycles in Kleeman's room (models/localizers/speed/run_speed.h).
#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "models/localizers/kleeman/kleeman.h"
#include "models/localizers/speed/run_speed.h"
#include "tests/models/localizers/kleeman_room.h"
#include "tests/support/statistics.h"

namespace octant {
namespace kleeman_speed_test {

using test::error_of;
using test::hear;
using test::Hearing;
using test::kleeman_room;
using test::kPrototypeSigma_s;
using test::kPublished;
using test::locate;

constexpr std::uint64_t kSpeedSeed = 1995;

/// "The speed of sound is resolved down to 0.25 %", from the redundancy of a few cycles, with an initial
/// error of up to 3 %: with omnidirectional receivers immediately, and with his, whose weak pulses are late.
TEST(KleemanSpeed, FollowsFromRedundancy) {
  std::mt19937_64 random(kSpeedSeed);
  std::cout << "seed " << kSpeedSeed << "\n";
  double normalised = 0.0, worst = 0.0;
  int count = 0;
  const auto estimate_at = [&](const Deployment& d, double truth, const test::PublishedSpread& place) {
    Deployment world = d;
    world.medium.speed_mps = truth * 345.0;
    MeasurementLog cycles;
    cycles.has_epochs = true;
    std::vector<Arrival> first;
    for (int epoch = 0; epoch < 4; ++epoch) {
      Hearing hearing{.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.01 * epoch};
      if (d.attenuation) hearing.half_angle_rad = M_PI, hearing.amplitude_sigma = 0.05;
      const auto heard = hear(world, Pose::planar(place.x_m, place.y_m, 0.7 * epoch), hearing, random, epoch);
      cycles.arrivals.insert(cycles.arrivals.end(), heard.begin(), heard.end());
      if (epoch == 0) first = heard;
    }
    const RunSpeed speed = estimate_run_speed(d, cycles);
    ASSERT_TRUE(speed.determined);
    EXPECT_EQ(speed.poses, 4u);
    const double error_mps = d.medium.speed_mps + speed.offset_mps - truth * 345.0;
    worst = std::max(worst, std::abs(error_mps / (truth * 345.0)));
    normalised += std::pow(error_mps / speed.sigma_mps, 2);
    ++count;
    Kleeman kleeman(at_speed(d, speed));
    const Fix fix = locate(kleeman, first);
    ASSERT_TRUE(fix.ok());
    EXPECT_LT(error_of(fix, Pose::planar(place.x_m, place.y_m, 0.0)).head<2>().norm(), 0.05);
  };
  for (const Deployment& d : {kleeman_room(), test::directional_room()})
    for (const double truth : {0.97, 0.99, 1.0, 1.013, 1.03})
      for (const auto& place : kPublished) estimate_at(d, truth, place);
  std::cout << "worst " << 100 * worst << " %\n";
  EXPECT_LT(worst, 0.0025);
  EXPECT_GT(normalised, test::chi2_quantile(1e-4, count));
  EXPECT_LT(normalised, test::chi2_quantile(1 - 1e-4, count));
}

/// In the centre of a ring all distances are equal for any speed: reported as undetermined.
TEST(KleemanSpeed, IsNotDeterminedFromTheMiddleOfARing) {
  std::mt19937_64 random(kSpeedSeed);
  Deployment d = kleeman_room();
  for (std::size_t b = 0; b < 6; ++b)
    d.beacons[b].position_m.head<2>() =
        Eigen::Vector2d(5 + 5 * std::cos(b * M_PI / 3), 5 + 5 * std::sin(b * M_PI / 3));
  const Hearing hearing{.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.02};
  MeasurementLog cycle;
  cycle.has_epochs = true;
  EXPECT_FALSE(estimate_run_speed(d, cycle).determined);
  cycle.arrivals = hear(d, Pose::planar(5, 5, 0.1), hearing, random);
  EXPECT_FALSE(estimate_run_speed(d, cycle).determined);
}

}  // namespace kleeman_speed_test
}  // namespace octant
