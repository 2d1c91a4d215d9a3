// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shoval and Borenstein's laboratory: two robots with receivers 350 mm apart and a transmitter between them,
// and the signal from burst to comparator.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "models/deployment.h"
#include "models/localizers/binaural/binaural.h"
#include "models/run.h"
#include "models/simulator/random.h"

namespace octant::test {

inline constexpr double kBase_m = 0.35;
inline constexpr double kDegree = std::numbers::pi / 180.0;

/// Robot 2 is the map, looking along x; robot 1 looks along its own x. Beacons: T2, R2l, R2r; receivers: t,
/// l, r.
inline Deployment two_robots(double tof_sigma_s = 1e-6) {
  Deployment d;
  d.medium.speed_mps = 343.0;
  d.noise.tof_sigma_s = tof_sigma_s;
  const std::array<double, 3> y = {0.0, kBase_m / 2, -kBase_m / 2};
  const std::array<const char*, 3> two = {"T2", "R2l", "R2r"}, one = {"t", "l", "r"};
  for (std::size_t i = 0; i < 3; ++i) {
    DeploymentBeacon b;
    b.name = two[i];
    b.position_m = {0.0, y[i], 0.3};
    d.beacons.push_back(b);
    DeploymentReceiver r;
    r.name = one[i];
    r.vehicle = VehicleId(0);
    r.position_m = {0.0, y[i], 0.3};
    d.receivers.push_back(r);
  }
  d.vehicles.push_back({.name = "robot1", .receiver_count = 3});
  return d;
}

/// The four links, beacon and receiver.
inline constexpr std::array<std::array<int, 2>, 4> kLinks = {{{0, 1}, {0, 2}, {1, 0}, {2, 0}}};

inline Arrival arrival(int beacon, int receiver, double tof_s) {
  Arrival a;
  a.tof_s = tof_s;
  a.beacon = BeaconId(beacon);
  a.receiver = ReceiverId(receiver);
  a.vehicle = VehicleId(0);
  a.epoch = 0;
  return a;
}

inline double distance_m(const Deployment& d, const Pose& T, int beacon, int receiver) {
  return (T * d.receivers[static_cast<std::size_t>(receiver)].position_m -
          d.beacons[static_cast<std::size_t>(beacon)].position_m)
      .norm();
}

/// Arrivals of the four links with white noise.
inline std::vector<Arrival> exchange(const Deployment& d, const Pose& T, double noise_s, Random& random) {
  std::vector<Arrival> out;
  for (const auto& [b, r] : kLinks) {
    const double delay_s =
        d.beacons[static_cast<std::size_t>(b)].delay_s + d.receivers[static_cast<std::size_t>(r)].delay_s;
    out.push_back(
        arrival(b, r, distance_m(d, T, b, r) / d.speed_mps(20.0) + delay_s + noise_s * random.normal()));
  }
  return out;
}

/// Transmitter, air and comparator. Polaroid bursts: 16 cycles at 49.4 kHz. The envelope rises within two
/// cycles; what comes weaker crosses the threshold cycles later.
struct Sonar {
  double amplitude_1m_v = 1.0;
  double absorption_np_per_m = 0.15;  // 1.3 dB/m at 50 kHz
  double threshold_v = 0.01;  // half of the first cycle's peak at 5 m: beyond, a receiver may miss a cycle
                              // received by the other robot
  double noise_v = 0.0005;
  double rise_time_s = 30e-6;
  double carrier_hz = 49.4e3;
  double sample_rate_hz = 2e6;
  int cycles = 16;

  /// Comparator's output from the firing on: up above the threshold, down again below zero.
  [[nodiscard]] std::vector<std::uint8_t> hear(double distance_m, double gain, double speed_mps,
                                               Random& random) const {
    const double tof_s = distance_m / speed_mps, burst_s = cycles / carrier_hz;
    const double amplitude = gain * amplitude_1m_v / distance_m * std::exp(-absorption_np_per_m * distance_m);
    std::vector<std::uint8_t> train(static_cast<std::size_t>((tof_s + burst_s + 1e-4) * sample_rate_hz), 0);
    bool up = false;
    for (auto i = static_cast<std::size_t>(tof_s * sample_rate_hz); i < train.size(); ++i) {
      const double t = static_cast<double>(i) / sample_rate_hz - tof_s;
      const double envelope = t < 0 ? 0.0
                                    : (1 - std::exp(-std::min(t, burst_s) / rise_time_s)) *
                                          std::exp(-std::max(0.0, t - burst_s) / rise_time_s);
      const double v =
          amplitude * envelope * std::sin(2 * std::numbers::pi * carrier_hz * t) + noise_v * random.normal();
      up = up ? v > 0 : v > threshold_v;
      train[i] = up;
    }
    return train;
  }
};

/// Rising edges of a comparator's train, up to one for each cycle of the burst: the first [s], and their mean
/// phase within the carrier's period, as a circular mean that a missed edge does not affect.
struct Edges {
  int count = 0;
  double first_s = 0.0;
  double phase_rad = 0.0;
};

inline Edges rising_edges(std::span<const std::uint8_t> train, const Sonar& sonar) {
  Edges edges;
  double cosine = 0.0, sine = 0.0;
  for (std::size_t i = 1; i < train.size() && edges.count < sonar.cycles; ++i) {
    if (train[i - 1] != 0 || train[i] == 0) continue;
    const double edge_s = (static_cast<double>(i) - 0.5) / sonar.sample_rate_hz;
    if (edges.count++ == 0) edges.first_s = edge_s;
    const double phase = 2 * std::numbers::pi * sonar.carrier_hz * (edge_s - edges.first_s);
    cosine += std::cos(phase);
    sine += std::sin(phase);
  }
  // Relative to the first edge until here, which keeps the angles small and so exact.
  const double first = std::remainder(sonar.carrier_hz * edges.first_s, 1.0) * 2 * std::numbers::pi;
  edges.phase_rad = wrap_angle(first + std::atan2(sine, cosine));
  return edges;
}

/// Times of flight to two receivers from their trains (Shoval and Borenstein, figure 2). The first edges give
/// their mean, valid over any distance. The phase of all edges gives their difference, accurate to a fraction
/// of a sample within one period, and the first edges determine the cycle.
inline std::optional<std::array<double, 2>> pulse_times_s(std::span<const std::uint8_t> left,
                                                          std::span<const std::uint8_t> right,
                                                          const Sonar& sonar) {
  constexpr int kLeastEdges = 4;
  const Edges l = rising_edges(left, sonar), r = rising_edges(right, sonar);
  if (l.count < kLeastEdges || r.count < kLeastEdges) return std::nullopt;
  const double by_phase = wrap_angle(r.phase_rad - l.phase_rad) / (2 * std::numbers::pi);
  const double cycles = std::round((r.first_s - l.first_s) * sonar.carrier_hz - by_phase);
  const double difference_s = (by_phase + cycles) / sonar.carrier_hz, mean_s = (l.first_s + r.first_s) / 2;
  return std::array<double, 2>{mean_s - difference_s / 2, mean_s + difference_s / 2};
}

/// Strength off a sonar's axis relative to that on it: 1 up to 10 degrees, then a cosine down to zero at 35.
inline double sonar_gain(double off_axis_rad) {
  const double share = (std::abs(off_axis_rad) - 10 * kDegree) / (25 * kDegree);
  return std::cos(std::clamp(share, 0.0, 1.0) * std::numbers::pi / 2);
}

/// Obstacle on each link: transmitted strength, and length of the detour.
struct Obstruction {
  std::array<double, 4> gain = {1, 1, 1, 1};
  std::array<double, 4> detour_m = {0, 0, 0, 0};
};

/// One measuring cycle of both robots, from bursts to arrivals. T may be tilted; beams weaken as in
/// `sonar_gain`, at both ends, horizontally. A train without a burst gives no arrival.
inline std::vector<Arrival> chirp(const Deployment& d, const Pose& T, const Sonar& sonar, Random& random,
                                  const Obstruction& way = {}) {
  std::vector<Arrival> out;
  const double speed = d.speed_mps(20.0);
  const Eigen::Vector2d facing1 = (T.rotation * Eigen::Vector3d::UnitX()).head<2>().normalized();
  for (std::size_t pair = 0; pair < 4; pair += 2) {
    std::array<std::vector<std::uint8_t>, 2> train;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto [b, r] = kLinks[pair + k];
      const Eigen::Vector3d sight = T * d.receivers[static_cast<std::size_t>(r)].position_m -
                                    d.beacons[static_cast<std::size_t>(b)].position_m;
      const Eigen::Vector2d flat = sight.head<2>().normalized();
      const double off2 = std::acos(std::min(1.0, flat.x())),
                   off1 = std::acos(std::min(1.0, -flat.dot(facing1)));
      const double gain = sonar_gain(off1) * sonar_gain(off2);
      train[k] = sonar.hear(sight.norm() + way.detour_m[pair + k], gain * way.gain[pair + k], speed, random);
    }
    const auto tof_s = pulse_times_s(train[0], train[1], sonar);
    if (!tof_s) continue;
    for (std::size_t k = 0; k < 2; ++k)
      out.push_back(arrival(kLinks[pair + k][0], kLinks[pair + k][1], (*tof_s)[k]));
  }
  return out;
}

}  // namespace octant::test
