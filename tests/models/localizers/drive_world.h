// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <iostream>
#include <random>
#include <vector>

#include "models/deployment.h"
#include "models/run.h"
#include "tests/models/localizers/hall.h"

namespace octant::test {

struct Drive {
  MeasurementLog log;
  std::vector<TimedPose> truth;  ///< at the odometry rows
};

/// Winding drive through the hall at 0.6 m/s, one beacon each 50 ms, odometry with noise.
inline Drive drive(const Deployment& d, double seconds, double noise_s, double odometry_share,
                   std::uint64_t seed) {
  std::cout << "seed " << seed << "\n";
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Drive out;
  out.log.vehicle = VehicleId(0);
  out.log.odometry_accuracy = {.distance_sigma_m_per_sqrt_m = 0.01,
                               .heading_sigma_rad_per_sqrt_m = 0.0087,
                               .heading_sigma_per_rad = 0.0,
                               .floor_m = 1e-4,
                               .floor_rad = 1e-4};
  const auto at = [](double t) {
    const double x = 10 + 6.5 * std::sin(0.09 * t + 0.3), y = 6 + 3.5 * std::sin(0.131 * t);
    return Pose::planar(x, y,
                        std::atan2(3.5 * 0.131 * std::cos(0.131 * t), 6.5 * 0.09 * std::cos(0.09 * t + 0.3)));
  };
  const double dt = 0.05;
  // The pose between two odometry rows is interpolated, so that noise is the only error.
  for (int k = 0; k * dt <= seconds; ++k) {
    const Pose T = at(k * dt);
    OdometryStep step{k * dt, 0, 0, 0, VehicleId(0)};
    if (k > 0) {
      const Pose rel = out.truth.back().T_map_vehicle.inverse() * T;
      const double s = odometry_share * std::sqrt(rel.translation_m.norm());
      step.dx_m = rel.translation_m.x() + 0.01 * s * normal(random);
      step.dy_m = rel.translation_m.y() + 0.01 * s * normal(random);
      step.dheading_rad = rel.heading_rad() + 0.0087 * s * normal(random);
    }
    out.log.odometry.push_back(step);
    out.truth.push_back({k * dt, T});
  }
  for (int shot = 0; (shot + 2) * dt < seconds; ++shot) {
    const double time_s = shot * dt + 0.013;
    const Pose T = interpolate(out.truth[static_cast<std::size_t>(shot)].T_map_vehicle,
                               out.truth[static_cast<std::size_t>(shot) + 1].T_map_vehicle, 0.26);
    Deployment one = d;
    one.beacons = {d.beacons[static_cast<std::size_t>(shot) % d.beacons.size()]};
    for (Arrival a : hear(one, T, {.noise_s = noise_s}, random, kNoEpoch, time_s)) {
      a.beacon = BeaconId(static_cast<std::size_t>(shot) % d.beacons.size());
      out.log.arrivals.push_back(a);
    }
  }
  return out;
}

}  // namespace octant::test
