// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/range.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace octant {
namespace {

constexpr double kMinDistance_m = 1e-6;
constexpr int kMostSteps = 80;

struct PredictedWalk {
  double walk_s = 0.0;
  double by_distance = 0.0;  ///< s/m
};

PredictedWalk predicted_walk(double distance_m, const AttenuationModel& a, double log_gain) {
  const double share = a.threshold_v / (amplitude_v(distance_m, a) * std::exp(log_gain));
  if (!(share < kMostPredictedShare)) return {walk_of_share_s(kMostPredictedShare, a), 0.0};
  const double steepness_s = a.rise_time_s * share / (1 - share);  // d walk / d ln(1/A)
  return {walk_of_share_s(share, a), steepness_s * (1 / distance_m + a.absorption_np_per_m)};
}

}  // namespace

double walk_of_share_s(double share, const AttenuationModel& a) {
  return -a.rise_time_s * std::log1p(-share);
}

TimedRange range_with_walk(const FlightTime& f, const AttenuationModel& a, double log_gain) noexcept {
  const double path_m = f.speed_mps * f.time_s;
  TimedRange out{path_m / f.legs, f.speed_mps / f.legs};
  if (!(path_m > 0)) return out;
  // The left side increases with d, so Newton's step is kept within a bracket.
  double low_m = kMinDistance_m, high_m = std::max(out.range_m, kMinDistance_m), d_m = high_m;
  double slope = f.legs;
  for (int i = 0; i < kMostSteps; ++i) {
    const PredictedWalk walk = predicted_walk(d_m, a, log_gain);
    const double excess_m = f.legs * d_m + f.speed_mps * walk.walk_s - path_m;
    slope = f.legs + f.speed_mps * walk.by_distance;
    (excess_m > 0 ? high_m : low_m) = d_m;
    double next_m = d_m - excess_m / slope;
    if (!(next_m > low_m && next_m < high_m)) next_m = 0.5 * (low_m + high_m);
    const bool converged = std::abs(next_m - d_m) < 1e-15 * high_m;
    d_m = next_m;
    if (converged) break;
  }
  return {d_m, f.speed_mps / slope};
}

double off_axis_walk_sigma_s(double distance_m, const AttenuationModel& a, double log_gain) noexcept {
  const double d_m = std::max(distance_m, kMinDistance_m);
  return predicted_walk(d_m, a, log_gain - std::numbers::ln2 / 2).walk_s -
         predicted_walk(d_m, a, log_gain).walk_s;
}

}  // namespace octant
