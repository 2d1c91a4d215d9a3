// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small scenarios for tests. Start from one, change a field or two, simulate.

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/physics/receiver_array.h"
#include "models/simulator/synthetic.h"

namespace octant::test {

/// The value, or an exception with the error's message, so that a test stops with the reason.
template <class T>
T must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

/// A beacon known to sigma_m; 0: control point, no value: unknown position.
inline SiteBeacon beacon(const std::string& name, const Eigen::Vector3d& p_map_m,
                         std::optional<double> sigma_m) {
  SiteBeacon b;
  b.name = name;
  for (std::size_t i = 0; i < 3; ++i) {
    b.position_m[i] = p_map_m[static_cast<Eigen::Index>(i)];
    b.sigma_m[i] = sigma_m;
  }
  return b;
}

/// Adds a vehicle with Kleeman's octagon, 50 mm sides.
inline void add_octagon(Site& site, double height_m = 0.3, double sigma_m = 0.001,
                        const std::string& name = "robot") {
  const VehicleId vehicle(site.vehicles.size());
  site.vehicles.push_back({.name = name, .first_receiver = site.receivers.size(), .receiver_count = 8});
  int i = 0;
  for (const ArrayElement& corner : octagon(0.05, height_m)) {
    std::string receiver = "r";
    receiver += std::to_string(i++);
    site.receivers.push_back({.name = receiver,
                              .vehicle = vehicle,
                              .position_m = corner.position_m,
                              .sigma_m = Eigen::Vector3d::Constant(sigma_m),
                              .axis = corner.axis});
  }
}

/// Adds a vehicle with receivers without axes at the places given.
inline void add_receivers(Site& site, const std::vector<Eigen::Vector3d>& p_vehicle_m, double sigma_m = 0.0,
                          const std::string& name = "robot") {
  const VehicleId vehicle(site.vehicles.size());
  site.vehicles.push_back(
      {.name = name, .first_receiver = site.receivers.size(), .receiver_count = p_vehicle_m.size()});
  for (std::size_t i = 0; i < p_vehicle_m.size(); ++i) {
    std::string receiver = "r";
    receiver += std::to_string(i);
    site.receivers.push_back({.name = receiver,
                              .vehicle = vehicle,
                              .position_m = p_vehicle_m[i],
                              .sigma_m = Eigen::Vector3d::Constant(sigma_m),
                              .axis = std::nullopt});
  }
}

/// A hall of 20 x 12 m with eight beacons round the walls (B0, B3, B6 control points, the others to 0.3 m),
/// an octagon, delays by beacon, 1.5 degrees of temperature error, 120 stops with some 16 arrivals each.
inline Scenario hall_scenario() {
  Scenario s;
  s.site.name = "hall";
  s.site.medium = {.model = MediumModel::kCramer1993, .temperature_degC = 21.0};
  s.site.speed_sigma_mps = 2.0;
  s.site.timing.delay_per.beacon = true;
  s.site.timing.delay_s = 1e-4;
  s.site.timing.delay_sigma_s = 5e-5;
  s.site.noise.tof_sigma_s = 1e-5;
  const double places[8][3] = {{3.90, 0.05, 2.520},  {11.85, 0.05, 2.455},  {19.95, 0.30, 2.560},
                               {19.95, 8.15, 2.480}, {16.20, 11.95, 2.505}, {7.70, 11.95, 2.610},
                               {0.05, 11.50, 2.430}, {0.05, 3.70, 2.540}};
  for (int i = 0; i < 8; ++i) {
    std::string name = "B";
    name += std::to_string(i);
    s.site.beacons.push_back(
        beacon(name, {places[i][0], places[i][1], places[i][2]}, i % 3 == 0 ? 0.0 : 0.3));
  }
  add_octagon(s.site);
  s.site.tolerance = {.beacon_m = 0.03, .fix_m = 0.05};
  s.hearing_half_angle_rad = 1.18;
  s.true_temperature_offset_degC = 1.5;
  s.true_delay_s = {5e-5, 1.5e-4};
  s.heldout_path.epochs = 40;
  return s;
}

/// The hall with a drive at 0.6 m/s with odometry at 20 Hz.
inline Scenario drive_scenario(double duration_s = 120.0) {
  Scenario s = hall_scenario();
  for (Scenario::Path* path : {&s.path, &s.heldout_path}) {
    path->kind = PathKind::kDrive;
    path->duration_s = duration_s;
  }
  return s;
}

/// A world without noise and unknowns: measured values equal the measurement equation's.
inline Scenario without_noise(Scenario s) {
  s.site.noise.tof_sigma_s = 0.0;
  s.site.noise.amplitude_relative_sigma = 0.0;
  s.odometry_accuracy = {.distance_sigma_m_per_sqrt_m = 0.0,
                         .heading_sigma_rad_per_sqrt_m = 0.0,
                         .floor_m = 0.0,
                         .floor_rad = 0.0};
  s.pose_accuracy = {.position_sigma_m = 0.0, .heading_sigma_rad = 0.0, .attitude_sigma_rad = 0.0};
  return s;
}

/// Attenuation with lateness of some 4 to 280 us out to 14 m.
inline void add_attenuation(Scenario& s) {
  s.site.attenuation = AttenuationPrior{.amplitude_1m_v = {12.5, 1.25},
                                        .absorption_np_per_m = {0.12, 0.02},
                                        .rise_time_s = {4.5e-4, 1e-4},
                                        .threshold_v = 0.05};
  s.range_m = 14.0;
}

}  // namespace octant::test
