// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The noise of a simulated world has the distributions of the scenario. Bounds are chi-square and binomial
// quantiles at 1e-4 on each side; seeds are fixed.
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "models/physics/measurement.h"
#include "models/simulator/synthetic.h"
#include "models/trajectory/shared_state.h"
#include "tests/support/statistics.h"
#include "tests/support/worlds.h"

namespace octant {
namespace synthetic_noise_test {

using test::drive_scenario;
using test::hall_scenario;
using test::must;

void expect_chi2(double sum, double dof, const char* what) {
  EXPECT_GT(sum, test::chi2_quantile(1e-4, dof)) << what << ", " << dof << " degrees of freedom";
  EXPECT_LT(sum, test::chi2_quantile(1 - 1e-4, dof)) << what << ", " << dof << " degrees of freedom";
}

/// Measured less true time of flight of each arrival of a stop-and-go run.
std::vector<double> errors_s(const World& w) {
  std::map<std::int64_t, Pose> stops;
  for (const TimedPose& p : w.run.truth)
    stops.emplace(static_cast<std::int64_t>((p.time_s - 10.0) / 5.0 + 1e-6), p.T_map_vehicle);
  std::vector<double> errors;
  for (const Arrival& a : w.run.arrivals) {
    PathInput in;
    in.T_map_vehicle = &stops.at(a.epoch);
    in.p_beacon_map_m = w.truth.beacons[a.beacon.index()].position_m;
    in.p_receiver_vehicle_m = w.truth.receivers[a.receiver.index()].position_m;
    in.speed_mps = w.truth.speed_mps(21.0);
    in.delay_s = w.truth.beacons[a.beacon.index()].delay_s;
    in.attenuation = w.truth.attenuation ? &*w.truth.attenuation : nullptr;
    errors.push_back(a.tof_s - predict_arrival_value(in).tof_s);
  }
  return errors;
}

TEST(SyntheticNoise, TimesOfFlight) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const World w = must(simulate(hall_scenario(), seed));
    double chi2 = 0, mean = 0;
    for (double e : errors_s(w)) chi2 += e * e / 1e-10, mean += e / 1e-5;
    const double n = static_cast<double>(w.run.arrivals.size());
    expect_chi2(chi2, n, "tof_s");
    EXPECT_LT(std::abs(mean) / std::sqrt(n), 3.9) << seed;
  }
}

TEST(SyntheticNoise, Amplitudes) {
  Scenario s = hall_scenario();
  test::add_attenuation(s);
  s.log_amplitude = true;
  const World w = must(simulate(s, 1));
  Scenario quiet = s;
  quiet.site.noise.amplitude_relative_sigma = 0.0;
  const World exact = must(simulate(quiet, 1));
  double chi2 = 0;
  for (std::size_t i = 0; i < w.run.arrivals.size(); ++i) {
    chi2 += std::pow((w.run.arrivals[i].amplitude_v / exact.run.arrivals[i].amplitude_v - 1) / 0.05, 2);
  }
  expect_chi2(chi2, static_cast<double>(w.run.arrivals.size()), "amplitude_v");
}

TEST(SyntheticNoise, Odometry) {
  Scenario s = drive_scenario(120.0);
  s.odometry_accuracy = {.distance_sigma_m_per_sqrt_m = 0.01,
                         .heading_sigma_rad_per_sqrt_m = 0.02,
                         .heading_sigma_per_rad = 0.5,
                         .floor_m = 1e-3,
                         .floor_rad = 2e-3};
  const World w = must(simulate(s, 2));
  double along = 0, across = 0, turn = 0;
  for (std::size_t i = 1; i < w.run.odometry.size(); ++i) {
    const Pose move = w.run.truth[i - 1].T_map_vehicle.inverse() * w.run.truth[i].T_map_vehicle;
    const double d = move.translation_m.norm(), a = move.heading_rad();
    const double variance_m2 = 0.01 * 0.01 * d + 1e-6, variance_rad2 = 0.02 * 0.02 * d + 0.25 * a * a + 4e-6;
    along += std::pow(w.run.odometry[i].dx_m - move.translation_m.x(), 2) / variance_m2;
    across += std::pow(w.run.odometry[i].dy_m - move.translation_m.y(), 2) / variance_m2;
    turn += std::pow(w.run.odometry[i].dheading_rad - a, 2) / variance_rad2;
  }
  const double n = static_cast<double>(w.run.odometry.size() - 1);
  expect_chi2(along, n, "dx_m");
  expect_chi2(across, n, "dy_m");
  expect_chi2(turn, n, "dheading_rad");
}

TEST(SyntheticNoise, MeasuredPosesKeepTheirErrorForAStop) {
  Scenario s = hall_scenario();
  s.log_poses = true;
  s.pose_accuracy = {.position_sigma_m = 0.005, .heading_sigma_rad = 0.01};
  s.path.epochs = 500;
  const World w = must(simulate(s, 3));
  ASSERT_EQ(w.run.poses.size(), w.run.truth.size());
  double position = 0, heading = 0;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  double stops = 0;
  for (std::size_t i = 0; i < w.run.poses.size(); ++i) {
    const Pose &measured = w.run.poses[i].T_map_vehicle, &truth = w.run.truth[i].T_map_vehicle;
    EXPECT_EQ(measured.translation_m.z(), 0.0);
    if (measured.translation_m == last) continue;
    last = measured.translation_m;
    stops += 1;
    position += (measured.translation_m - truth.translation_m).squaredNorm() / (0.005 * 0.005);
    heading += std::pow(wrap_angle(measured.heading_rad() - truth.heading_rad()) / 0.01, 2);
  }
  EXPECT_EQ(stops, 500);
  expect_chi2(position, 2 * stops, "poses, position");
  expect_chi2(heading, stops, "poses, heading");
}

TEST(SyntheticNoise, UnknownHeadingIsNotGivenAway) {
  Scenario s = drive_scenario(10.0);
  s.log_poses = true;
  s.pose_accuracy.heading_known = false;
  for (const TimedPose& p : must(simulate(s, 3)).run.poses) EXPECT_EQ(p.T_map_vehicle.heading_rad(), 0.0);
}

TEST(SyntheticNoise, EchoesAreAsManyAndAsLateAsAsked) {
  Scenario s = hall_scenario();
  s.echo_fraction = 0.3;
  s.early_fraction = 0.02;
  s.path.epochs = 2000;
  const World w = must(simulate(s, 4));
  const std::vector<double> errors = errors_s(w);
  double late = 0, early = 0, lateness_chi2 = 0, log_mean = 0;
  std::map<std::pair<std::int64_t, int>, std::map<double, int>>
      groups;  // of an epoch's beacon: how often each lateness
  const double n = static_cast<double>(errors.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double late_s = w.run_lateness_s[i];
    lateness_chi2 += std::pow((errors[i] - late_s) / 1e-5, 2);
    ++groups[{w.run.arrivals[i].epoch, w.run.arrivals[i].beacon.value}][late_s];
    early += late_s < 0;
    if (late_s <= 0) continue;
    late += 1;
    EXPECT_GE(late_s, 0.3e-3);
    EXPECT_LE(late_s, 12e-3);
  }
  expect_chi2(lateness_chi2, n, "tof_s less lateness");
  // Shadowed groups of m arrivals count m at a time: the variance of the sum is p(1-p) sum m^2.
  double group_squares = 0, shadowed = 0, log_count = 0;
  for (const auto& [key, latenesses] : groups) {
    double m = 0;
    for (const auto& [late_s, count] : latenesses) {
      m += count;
      if (late_s > 0) log_mean += std::log(late_s / 0.3e-3) / std::log(40.0), log_count += 1;
      if (late_s > 0 && count > 1) shadowed += 1;
    }
    group_squares += m * m;
  }
  const double spread = std::sqrt(0.15 * 0.85 * group_squares + 0.3 * 0.7 * n);
  EXPECT_NEAR(late, 0.3 * 0.98 * n, 3.9 * spread);
  EXPECT_NEAR(early, 0.02 * n, 3.9 * std::sqrt(0.02 * 0.98 * n));
  EXPECT_NEAR(log_mean / log_count, 0.5, 3.9 / std::sqrt(12 * log_count));  // log-uniform
  // 15 % of the beacons of an epoch are shadowed; those received once do not show this, those with an early
  // arrival still do.
  double plural = 0;
  for (const auto& [key, latenesses] : groups) {
    int m = 0;
    for (const auto& [late_s, count] : latenesses) m += count;
    plural += m >= 3;
  }
  EXPECT_GT(shadowed, 0.15 * plural - 3.9 * std::sqrt(0.15 * 0.85 * plural));
}

TEST(SyntheticNoise, SpuriousArrivalsAreEarlyAndPositive) {
  Scenario s = hall_scenario();
  s.early_fraction = 0.2;
  const World w = must(simulate(s, 5));
  for (std::size_t i = 0; i < w.run.arrivals.size(); ++i) {
    EXPECT_GT(w.run.arrivals[i].tof_s, 0.0);
    EXPECT_LE(w.run_lateness_s[i], 0.0);
  }
}

TEST(SyntheticNoise, SiteFileKnowsBeaconsToTheirSigma) {
  Scenario s = hall_scenario();
  s.path.epochs = s.heldout_path.epochs = 1;
  s.site.distances.push_back({BeaconId(1), BeaconId(4), 0.0, 0.003});
  double beacons = 0, receivers = 0, tapes = 0;
  const int seeds = 200;
  for (int seed = 0; seed < seeds; ++seed) {
    const World w = must(simulate(s, static_cast<std::uint64_t>(seed)));
    for (std::size_t b = 0; b < 8; ++b) {
      for (std::size_t i = 0; i < 3; ++i) {
        const double error = *w.site.beacons[b].position_m[i] - *s.site.beacons[b].position_m[i];
        EXPECT_EQ(w.truth.beacons[b].position_m[static_cast<Eigen::Index>(i)],
                  *s.site.beacons[b].position_m[i]);
        if (b % 3 == 0)
          EXPECT_EQ(error, 0.0);
        else
          beacons += error * error / 0.09;
      }
    }
    for (std::size_t r = 0; r < 8; ++r) {
      const Eigen::Vector3d error = w.truth.receivers[r].position_m - w.site.receivers[r].position_m;
      EXPECT_LE(error.lpNorm<Eigen::Infinity>(), 0.002 + 1e-15);  // two sigma
      receivers += error.squaredNorm() / 1e-6;
    }
    const double length_m = (w.truth.beacons[1].position_m - w.truth.beacons[4].position_m).norm();
    tapes += std::pow((w.site.distances[0].distance_m - length_m) / 0.003, 2);
    for (const DeploymentBeacon& b : w.truth.beacons) EXPECT_TRUE(b.delay_s >= 5e-5 && b.delay_s < 1.5e-4);
  }
  expect_chi2(beacons, 15.0 * seeds, "beacon positions");
  expect_chi2(tapes, seeds, "control distances");
  // Clipping at two sigma leaves a variance of 0.9205; the bounds are scaled with it.
  const double dof = 24.0 * seeds;
  EXPECT_GT(receivers / 0.9205, test::chi2_quantile(1e-4, dof));
  EXPECT_LT(receivers / 0.9205, test::chi2_quantile(1 - 1e-4, dof));
}

TEST(SyntheticNoise, WhatNobodyKnowsIsNotInTheSiteFile) {
  Scenario s = hall_scenario();
  s.site.beacons[1].sigma_m = {std::nullopt, std::nullopt, 0.01};
  const World height = must(simulate(s, 1));
  EXPECT_FALSE(height.site.beacons[1].position_m[0] || height.site.beacons[1].position_m[1]);
  EXPECT_NEAR(height.site.beacons[1].position_m[2].value(), *s.site.beacons[1].position_m[2], 0.06);
  s.unknown_beacons = true;
  const World cold = must(simulate(s, 1));
  for (std::size_t b = 0; b < 8; ++b) {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(cold.site.beacons[b].position_m[i].has_value(), b % 3 == 0);
  }
}

TEST(SyntheticNoise, SpeedIsOffAsStatedOrAsThePriorSays) {
  Scenario s = hall_scenario();
  s.path.epochs = s.heldout_path.epochs = 1;
  EXPECT_NEAR(must(simulate(s, 1)).truth.speed_offset_mps,
              speed_mps(s.site.medium, 22.5) - speed_mps(s.site.medium, 21.0), 1e-12);
  s.true_speed_offset_mps = -1.25;
  EXPECT_EQ(must(simulate(s, 1)).truth.speed_offset_mps, -1.25);
  s.true_speed_offset_mps.reset();
  s.true_temperature_offset_degC.reset();
  double chi2 = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    chi2 += std::pow(must(simulate(s, seed)).truth.speed_offset_mps / 2.0, 2);
  EXPECT_GT(chi2 / 0.9205, test::chi2_quantile(1e-4, 200));
  EXPECT_LT(chi2 / 0.9205, test::chi2_quantile(1 - 1e-4, 200));
}

TEST(SyntheticNoise, PairsKeepTheirBias) {
  Scenario s = test::without_noise(hall_scenario());
  s.site.noise.pair_sigma_s = 1e-4;
  const World w = must(simulate(s, 6));
  const std::vector<double> errors = errors_s(w);
  std::map<std::pair<int, int>, double> bias;
  double chi2 = 0, sum = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const auto [it, is_new] =
        bias.emplace(std::pair(w.run.arrivals[i].beacon.value, w.run.arrivals[i].receiver.value), errors[i]);
    EXPECT_NEAR(errors[i], it->second, 1e-14);
    if (is_new) chi2 += errors[i] * errors[i] / 1e-8, sum += errors[i] / 1e-4;
  }
  expect_chi2(chi2, static_cast<double>(bias.size()), "pair biases");
  EXPECT_LT(std::abs(sum) / std::sqrt(static_cast<double>(bias.size())), 3.9);
}

}  // namespace synthetic_noise_test
}  // namespace octant
