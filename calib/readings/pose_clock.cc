// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pose_clock.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <boost/math/tools/minima.hpp>

namespace octant::calib {

bool poses_are_of_motion(const MeasurementLog& run) {
  constexpr double kSlowest_mps = 0.01, kMovingShare = 0.1;
  std::size_t pairs = 0, moving = 0;
  for (std::size_t i = 1; i < run.poses.size(); ++i) {
    const TimedPose &a = run.poses[i - 1], &b = run.poses[i];
    const double dt_s = b.time_s - a.time_s;
    if (dt_s > run.pose_accuracy.max_gap_s) continue;
    ++pairs;
    moving += (b.T_map_vehicle.translation_m - a.T_map_vehicle.translation_m).norm() > kSlowest_mps * dt_s;
  }
  return static_cast<double>(moving) > kMovingShare * static_cast<double>(pairs);
}

void take_back_lag(double lag_s, MeasurementLog& run) {
  for (TimedPose& pose : run.poses) pose.time_s -= lag_s;
}

double likeliest_lag_s(const std::function<double(double lag_s)>& loss) {
  constexpr double kLeast_s = 0.02, kMost_s = 2.0;
  constexpr int kBits = 8;
  constexpr std::uintmax_t kMostSteps = 12;
  double best_s = kLeast_s, least = INFINITY;
  for (double size_s = kLeast_s; size_s < kMost_s; size_s *= 2)
    for (const double lag_s : {size_s, -size_s})
      if (const double here = loss(lag_s); here < least) {
        least = here;
        best_s = lag_s;
      }
  std::uintmax_t steps = kMostSteps;
  const auto [log_s, refined] = boost::math::tools::brent_find_minima(
      [&](double log_size) { return loss(std::copysign(std::exp(log_size), best_s)); },
      std::log(std::abs(best_s) / 2), std::log(std::abs(best_s) * 2), kBits, steps);
  return refined < least ? std::copysign(std::exp(log_s), best_s) : best_s;
}

}  // namespace octant::calib
