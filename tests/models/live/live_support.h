// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "models/live/follower.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant::test {

/// A follower that stores its results.
struct Live {
  explicit Live(const Deployment& d, const FollowOptions& options = {}) : follower(d, options) {
    follower.on_fix = [this](const Fix& fix) { fixes.push_back(fix); };
    follower.on_alarm = [this](const WatchAlarm& alarm) { alarms.push_back(alarm); };
  }
  Follower follower;
  std::vector<Fix> fixes;
  std::vector<WatchAlarm> alarms;
};

/// Arrivals and rows of a drive, each at the time at which it is delivered.
struct Delivery {
  double time_s = 0.0;
  const Arrival* arrival = nullptr;
  const OdometryStep* row = nullptr;
};

inline std::vector<Delivery> deliveries(const MeasurementLog& log) {
  std::vector<Delivery> all;
  for (const OdometryStep& row : log.odometry) all.push_back({row.time_s, nullptr, &row});
  for (const Arrival& a : log.arrivals) all.push_back({a.time_s, &a, nullptr});
  return all;
}

inline void deliver(std::vector<Delivery> all, Follower& follower) {
  std::ranges::stable_sort(all, {}, &Delivery::time_s);
  for (const Delivery& one : all) one.row ? follower.move(*one.row) : follower.hear(*one.arrival);
  follower.flush();
}

/// Errors of the fixes that are ok, in the plane, and their bounds.
struct Errors {
  std::size_t ok = 0, beyond_level = 0, beyond_ten_sigmas = 0;
  double rms_m = 0.0, first_s = std::numeric_limits<double>::infinity();
};

inline Errors errors_of(const std::vector<Fix>& fixes, const std::vector<TimedPose>& truth,
                        double from_s = 0.0, double until_s = 1e9) {
  Errors out;
  for (const Fix& fix : fixes) {
    Pose T;
    if (!fix.ok() || fix.time_s < from_s || fix.time_s > until_s ||
        !interpolate_poses(truth, fix.time_s, 1.0, T))
      continue;
    const double off_m = (fix.T_map_vehicle.translation_m - T.translation_m).head<2>().norm();
    ++out.ok;
    out.first_s = std::min(out.first_s, fix.time_s);
    out.rms_m += off_m * off_m;
    out.beyond_level += integrity(fix) == Integrity::kOk && off_m > fix.protection_level_m;
    out.beyond_ten_sigmas += off_m > 10 * std::sqrt(0.5 * (fix.covariance(0, 0) + fix.covariance(1, 1)));
  }
  out.rms_m = std::sqrt(out.rms_m / static_cast<double>(std::max<std::size_t>(out.ok, 1)));
  return out;
}

inline void expect_honest(const Errors& errors) {
  EXPECT_EQ(errors.beyond_level, 0u);
  EXPECT_EQ(errors.beyond_ten_sigmas, 0u);
}

inline FollowOptions with_accuracy_of(const MeasurementLog& log) {
  FollowOptions options;
  options.odometry = log.odometry_accuracy;
  return options;
}

}  // namespace octant::test
