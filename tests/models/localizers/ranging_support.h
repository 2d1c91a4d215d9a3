// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small worlds for localizers that work on ranges: beacons, receivers, arrivals of one stop, and how good a
// fix is.

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "models/localizers/common/localizer.h"
#include "tests/models/localizers/hall.h"

namespace octant::test {

/// A planar site in air with a constant speed, beacons at the places given, a vehicle with receivers at the
/// places given.
inline Deployment ranging_site(const std::vector<Eigen::Vector3d>& beacons_m,
                               const std::vector<Eigen::Vector3d>& receivers_m) {
  Deployment d;
  d.medium.speed_mps = 343.7;
  d.noise.tof_sigma_s = 1e-5;
  for (std::size_t i = 0; i < beacons_m.size(); ++i) {
    DeploymentBeacon b;
    b.name = "B" + std::to_string(i);
    b.position_m = beacons_m[i];
    b.delay_s = 1e-4 + 2e-5 * std::cos(2.0 * static_cast<double>(i));
    d.beacons.push_back(b);
  }
  d.vehicles.push_back({"robot", 0, 0});
  for (const Eigen::Vector3d& p : receivers_m) d = with_receiver(d, p);
  return d;
}

/// Normalised squared error (NEES) of a fix: e' C^-1 e of (x, y, heading).
inline double nees(const Fix& fix, const Pose& truth) {
  Eigen::Vector3d e;
  e << (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>(),
      wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad());
  return e.dot(Eigen::Matrix3d(fix.covariance).inverse() * e);
}

/// Covariance of a fix from numeric derivatives by each arrival's time: an independent reference for that of
/// the fix.
template <class AnyLocalizer>
Eigen::Matrix3d numeric_covariance(AnyLocalizer& localizer, std::vector<Arrival> arrivals, double sigma_s,
                                   double step_s = 1e-8) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (Arrival& arrival : arrivals) {
    const double tof_s = arrival.tof_s;
    arrival.tof_s = tof_s + step_s;
    const Pose high = localizer.locate({.arrivals = arrivals, .bearings = {}}).T_map_vehicle;
    arrival.tof_s = tof_s - step_s;
    const Pose low = localizer.locate({.arrivals = arrivals, .bearings = {}}).T_map_vehicle;
    arrival.tof_s = tof_s;
    Eigen::Vector3d by_time;
    by_time << (high.translation_m - low.translation_m).head<2>(),
        wrap_angle(high.heading_rad() - low.heading_rad());
    by_time *= sigma_s / (2 * step_s);
    sum += by_time * by_time.transpose();
  }
  return sum;
}

/// The nearest tick of the 20 MHz counter.
inline void count_at_20_mhz(std::vector<Arrival>& arrivals) {
  for (Arrival& arrival : arrivals) arrival.tof_s = std::round(arrival.tof_s * 20e6) / 20e6;
}

inline bool has_no_nan(const Fix& fix) {
  return fix.T_map_vehicle.translation_m.allFinite() && fix.T_map_vehicle.rotation.coeffs().allFinite() &&
         fix.covariance.allFinite() && std::isfinite(fix.cost) && std::isfinite(fix.time_s);
}

}  // namespace octant::test
