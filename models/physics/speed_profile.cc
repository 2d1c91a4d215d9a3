// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/speed_profile.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace octant {
namespace {

constexpr double kEarthRadius_m = 6.371e6;  ///< mean radius (IUGG R1)
constexpr int kMostIterations = 100;        ///< bisection alone reaches double precision in some 60

/// ln(1 + u) / u, which is 1 at u = 0.
double log1p_over(double u) { return std::abs(u) < 1e-12 ? 1.0 : std::log1p(u) / u; }

struct Ray {
  double horizontal_m = 0.0;
  double time_s = 0.0;
};

/// The ray of Snell's parameter p [s/m] through layers, from the first level to the last.
Ray trace(const std::vector<SpeedProfile::Level>& levels, double p) {
  Ray ray;
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const double h = levels[i].height_m - levels[i - 1].height_m;
    const double c1 = levels[i - 1].speed_mps, c2 = levels[i].speed_mps, change = c2 - c1;
    const double s1 = std::sqrt(std::max(0.0, 1 - p * p * c1 * c1));
    const double s2 = std::sqrt(std::max(0.0, 1 - p * p * c2 * c2));
    // ln(c2 / c1) and ln((1 + s1) / (1 + s2)), each divided by the change of speed.
    const double a = 1 / c1, b = p * p * (c1 + c2) / ((s1 + s2) * (1 + s2));
    ray.horizontal_m += p * h * (c1 + c2) / (s1 + s2);
    ray.time_s += h * (a * log1p_over(a * change) + b * log1p_over(b * change));
  }
  return ray;
}

}  // namespace

SpeedProfile::SpeedProfile(std::vector<Level> levels) : levels_(std::move(levels)) {}

double SpeedProfile::speed_at(double height_m) const {
  const auto above = std::ranges::upper_bound(levels_, height_m, {}, &Level::height_m);
  if (above == levels_.begin()) return levels_.front().speed_mps;
  if (above == levels_.end()) return levels_.back().speed_mps;
  const Level& lower = *std::prev(above);
  const double share = (height_m - lower.height_m) / (above->height_m - lower.height_m);
  return lower.speed_mps + share * (above->speed_mps - lower.speed_mps);
}

std::vector<SpeedProfile::Level> SpeedProfile::layers(double from_height_m, double to_height_m) const {
  const auto [low_m, high_m] = std::minmax(from_height_m, to_height_m);
  std::vector<Level> path = {{low_m, speed_at(low_m)}};
  for (const Level& level : levels_)
    if (level.height_m > low_m && level.height_m < high_m) path.push_back(level);
  path.push_back({high_m, speed_at(high_m)});
  return path;
}

double SpeedProfile::mean_speed_mps(double from_height_m, double to_height_m) const {
  if (from_height_m == to_height_m) return speed_at(from_height_m);
  return std::abs(to_height_m - from_height_m) / trace(layers(from_height_m, to_height_m), 0.0).time_s;
}

double SpeedProfile::travel_time_s(double horizontal_m, double from_height_m, double to_height_m) const {
  const std::vector<Level> path = layers(from_height_m, to_height_m);
  const double fastest_mps = std::ranges::max(path, {}, &Level::speed_mps).speed_mps;
  const double mean_mps = mean_speed_mps(from_height_m, to_height_m);
  const double straight_s = std::hypot(horizontal_m, to_height_m - from_height_m) / mean_mps;
  // The horizontal distance grows with p. The last value below 1 / fastest is the flattest direct ray.
  double low = 0.0, high = (1 - 1e-9) / fastest_mps;
  if (!(horizontal_m > 0)) return trace(path, 0.0).time_s;
  if (from_height_m == to_height_m || trace(path, high).horizontal_m < horizontal_m) return straight_s;
  double p = std::clamp(horizontal_m / (straight_s * mean_mps * mean_mps), low, high);
  double off_low = -horizontal_m, off_high = trace(path, high).horizontal_m - horizontal_m;
  for (int i = 0; i < kMostIterations; ++i) {
    const double off = trace(path, p).horizontal_m - horizontal_m;
    if (std::abs(off) < 1e-9 * horizontal_m) break;
    (off < 0 ? low : high) = p;
    (off < 0 ? off_low : off_high) = off;
    const double secant = low - off_low * (high - low) / (off_high - off_low);
    // Alternates with bisection: a secant alone may leave one end where it is.
    p = i % 3 == 2 ? 0.5 * (low + high) : secant;
  }
  return trace(path, p).time_s;
}

double SpeedProfile::effective_speed_mps(const Eigen::Vector3d& from_map_m,
                                         const Eigen::Vector3d& to_map_m) const {
  const double distance_m = (to_map_m - from_map_m).norm();
  const double mean_height_m = 0.5 * (from_map_m.z() + to_map_m.z());
  const double horizontal_m = (to_map_m - from_map_m).head<2>().norm() * (1 + mean_height_m / kEarthRadius_m);
  const double time_s = travel_time_s(horizontal_m, from_map_m.z(), to_map_m.z());
  return time_s > 0 ? distance_m / time_s : speed_at(from_map_m.z());
}

double sea_water_speed_mps(double temperature_degC, double salinity, double depth_m) {
  const double T = temperature_degC, S = salinity - 35, D = depth_m;
  return 1448.96 + 4.591 * T - 5.304e-2 * T * T + 2.374e-4 * T * T * T + 1.340 * S + 1.630e-2 * D +
         1.675e-7 * D * D - 1.025e-2 * T * S - 7.139e-13 * T * D * D * D;
}

}  // namespace octant
