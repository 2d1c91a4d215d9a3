// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "models/deployment.h"
#include "models/physics/measurement.h"
#include "models/physics/receiver_array.h"
#include "models/run.h"

namespace octant::test {

/// Beacons along the walls of a 20 x 12 m hall, 2.5 m up, with uneven heights and delays.
inline Deployment hall(int beacons = 8) {
  Deployment d;
  d.medium.speed_mps = 343.7;
  d.noise.tof_sigma_s = 1e-5;
  for (int i = 0; i < beacons; ++i) {
    const double s = (i + 0.37 + 0.2 * std::sin(5.0 * i)) * 64.0 / beacons;
    DeploymentBeacon b;
    b.name = "B" + std::to_string(i);
    b.position_m = s < 20   ? Eigen::Vector3d(s, 0, 0)
                   : s < 32 ? Eigen::Vector3d(20, s - 20, 0)
                   : s < 52 ? Eigen::Vector3d(52 - s, 12, 0)
                            : Eigen::Vector3d(0, 64 - s, 0);
    b.position_m.z() = 2.5 + 0.1 * std::sin(3.0 * i);
    b.delay_s = 1e-4 + 2e-5 * std::cos(2.0 * i);
    d.beacons.push_back(b);
  }
  d.vehicles.push_back({"robot", 0, 0});
  return d;
}

inline Deployment with_octagon(Deployment d) {
  for (const ArrayElement& e : octagon(0.05, 0.3)) {
    DeploymentReceiver r;
    r.name = "r" + std::to_string(d.receivers.size());
    r.vehicle = VehicleId(0);
    r.position_m = e.position_m;
    r.axis = e.axis;
    d.receivers.push_back(r);
  }
  d.vehicles[0].receiver_count = d.receivers.size();
  return d;
}

inline Deployment with_receiver(Deployment d, const Eigen::Vector3d& position_m) {
  DeploymentReceiver r;
  r.name = "r" + std::to_string(d.receivers.size());
  r.vehicle = VehicleId(0);
  r.position_m = position_m;
  d.receivers.push_back(r);
  d.vehicles[0].receiver_count = d.receivers.size();
  return d;
}

struct Hearing {
  double range_m = 12.0;
  double half_angle_rad = 1.178;  ///< 67.5 degrees, of receivers with an axis
  double noise_s = 0.0;
  double cycle_offset_s = 0.0;
  std::optional<double> amplitude_sigma{};  ///< relative; no value: not logged
};

/// Arrivals of one stop: each beacon in its slot, at each receiver in reach.
template <class Random>
std::vector<Arrival> hear(const Deployment& d, const Pose& T, const Hearing& h, Random& random,
                          std::int64_t epoch = 0, double time_s = 0.0) {
  std::vector<Arrival> out;
  std::normal_distribution<double> normal;
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    for (std::size_t r = 0; r < d.receivers.size(); ++r) {
      PathInput in;
      in.T_map_vehicle = &T;
      in.p_beacon_map_m = d.beacons[b].position_m;
      in.p_receiver_vehicle_m = d.receivers[r].position_m;
      in.speed_mps = d.speed_mps(d.medium.temperature_degC);
      in.delay_s = d.beacons[b].delay_s + d.receivers[r].delay_s + h.cycle_offset_s;
      in.attenuation = d.attenuation ? &*d.attenuation : nullptr;
      if (d.receivers[r].axis) in.axis_vehicle = &*d.receivers[r].axis;
      const PathOutput path = predict_arrival_value(in);
      if (path.distance_m > h.range_m || !path.heard) continue;
      if (d.receivers[r].axis) {
        const Eigen::Vector2d to = (d.beacons[b].position_m - T * d.receivers[r].position_m).head<2>();
        const Eigen::Vector2d axis = (T.rotation * *d.receivers[r].axis).head<2>();
        if (to.normalized().dot(axis) < std::cos(h.half_angle_rad)) continue;
      }
      Arrival a;
      if (h.amplitude_sigma)
        a.amplitude_v = std::exp(path.log_amplitude) * (1 + *h.amplitude_sigma * normal(random));
      a.time_s = time_s + 0.05 * static_cast<double>(b);
      a.tof_s = path.tof_s + h.noise_s * normal(random);
      a.beacon = BeaconId(b);
      a.receiver = ReceiverId(r);
      a.vehicle = VehicleId(0);
      a.epoch = epoch;
      out.push_back(a);
    }
  return out;
}

inline double position_error_m(const Pose& a, const Pose& b) {
  return (a.translation_m - b.translation_m).norm();
}

template <class Random>
Pose random_pose(Random& random) {
  std::uniform_real_distribution<double> x(2, 18), y(2, 10), h(-std::numbers::pi, std::numbers::pi);
  // Drawn one by one: compilers differ in the order in which they take a call's arguments.
  const double heading_rad = h(random), y_m = y(random), x_m = x(random);
  return Pose::planar(x_m, y_m, heading_rad);
}

}  // namespace octant::test
