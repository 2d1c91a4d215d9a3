// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Kleeman's room: 10 x 10 m, six beacons along the walls. The text, which lacks the paper's figure 1,
// excludes beacons 1 and 4 from the corners: so 0, 2, 3, 5 are in corners, and 1 and 4 in the middle of
// opposite walls.

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "models/deployment.h"
#include "models/localizers/kleeman/kleeman.h"
#include "tests/models/localizers/hall.h"
#include "tests/support/allocation_count.h"

namespace octant::test {

/// Standard deviation of an arrival: the polling of eight channels at 2.5 us each (20 us, 5.8 us rms) and the
/// ripple of a half-wave rectified envelope at 40 kHz (25 us, 7.2 us rms) make 9.2 us.
inline constexpr double kPrototypeSigma_s = 1.0e-5;

/// Height of the beacons above the floor, the array at 0.3 m. The paper does not give it; level: as in its
/// plane figures.
inline Deployment kleeman_room(double beacon_height_m = 2.0) {
  Deployment d;
  d.medium.speed_mps = 345.0;  // the paper's
  d.noise.tof_sigma_s = kPrototypeSigma_s;
  d.timing.clock = Clock::kCycleOffset;
  const double places[6][2] = {{0, 0}, {5, 0}, {10, 0}, {10, 10}, {5, 10}, {0, 10}};
  for (int i = 0; i < 6; ++i) {
    DeploymentBeacon b;
    b.name = "B";
    b.name += std::to_string(i);
    b.position_m = {places[i][0], places[i][1], beacon_height_m};
    d.beacons.push_back(b);
  }
  d.vehicles.push_back({"robot", 0, 0});
  return with_octagon(d);
}

/// His room with his receivers and pulses (section 2.3): 3 dB at 22.5 degrees, 12.5 V at 1 m, a threshold of
/// 0.2 V.
inline Deployment directional_room() {
  Deployment d = kleeman_room();
  d.attenuation = AttenuationModel{.amplitude_1m_v = 12.5,
                                   .threshold_v = 0.2,
                                   .rise_time_s = 4.5e-4,
                                   .half_power_angle_rad = M_PI / 8,
                                   .saturation_v = 4.7};
  return d;
}

/// The paper's table: position, and the standard deviation of x and y there [m].
struct PublishedSpread {
  double x_m, y_m, sigma_x_m, sigma_y_m;
};
inline constexpr std::array<PublishedSpread, 3> kPublished = {
    {{4.223, 7.902, 8.0e-3, 11.0e-3}, {4.003, 4.892, 6.8e-3, 4.3e-3}, {7.339, 5.885, 8.5e-3, 5.5e-3}}};

/// Echoes as in Octant's simulator: half of them from a beacon in a shadow, which is late at all receivers,
/// half of them single arrivals; log-uniform from 0.3 to 12 ms (0.1 to 4 m).
template <class Random>
void add_echoes(std::vector<Arrival>& arrivals, double fraction, Random& random) {
  std::uniform_real_distribution<double> uniform;
  const auto lateness_s = [&] { return 0.3e-3 * std::pow(40.0, uniform(random)); };
  std::array<double, 16> shadow_s{};
  for (double& s : shadow_s) s = uniform(random) < fraction / 2 ? lateness_s() : 0.0;
  for (Arrival& a : arrivals) {
    if (shadow_s[a.beacon.index()] > 0) {
      a.tof_s += shadow_s[a.beacon.index()];
    } else if (uniform(random) < fraction / 2) {
      a.tof_s += lateness_s();
    }
  }
}

/// Anywhere in the room, turned anyhow.
template <class Random>
Pose anywhere(Random& random, double margin_m = 0.25) {
  std::uniform_real_distribution<double> place(margin_m, 10 - margin_m), turn(-M_PI, M_PI);
  const double x = place(random), y = place(random);
  return Pose::planar(x, y, turn(random));
}

inline Fix locate(Kleeman& kleeman, const std::vector<Arrival>& arrivals) {
  return kleeman.locate(Observations{arrivals, {}});
}

/// Standard deviations of x, y, and the heading.
inline Eigen::Vector3d error_of(const Fix& fix, const Pose& truth) {
  Eigen::Vector3d e = fix.T_map_vehicle.translation_m - truth.translation_m;
  e[2] = wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad());
  return e;
}

/// Consecutive cycles allocate no memory after the first rejections.
inline void expect_no_allocations(Kleeman& kleeman, const std::vector<std::vector<Arrival>>& cycles) {
  std::size_t most = 0;
  for (const auto& arrivals : cycles) most = std::max(most, arrivals.size());
  Fix fix;
  fix.rejections.reserve(most);
  const std::size_t before = allocations();
  for (const auto& arrivals : cycles) kleeman.locate(Observations{arrivals, {}}, fix);
  EXPECT_EQ(allocations(), before);
}

}  // namespace octant::test
