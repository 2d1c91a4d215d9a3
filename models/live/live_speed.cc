// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/live/live_speed.h"

#include <utility>

namespace octant {
namespace {

constexpr std::size_t kFirstLook = 400, kMostKept = 3'200;  ///< arrivals

}  // namespace

LiveSpeed::LiveSpeed(Deployment calibrated) : calibrated_(std::move(calibrated)), wanted_(kFirstLook) {}

void LiveSpeed::hear(const Arrival& arrival) {
  kept_.arrivals.push_back(arrival);
  kept_.has_epochs = kept_.has_epochs || arrival.epoch != kNoEpoch;
}

void LiveSpeed::move(const OdometryStep& step) {
  if (kept_.odometry.size() < 16 * kMostKept) kept_.odometry.push_back(step);
}

std::optional<RunSpeed> LiveSpeed::estimate() {
  std::optional<RunSpeed> speed;
  if (speed_is_unknown(calibrated_, kept_)) speed = estimate_run_speed(calibrated_, kept_);
  if (speed && !speed->determined) {
    speed.reset();
    if (wanted_ < kMostKept) {
      wanted_ *= 2;
      return speed;
    }
  }
  wanted_ = kMostKept;
  kept_ = {};
  return speed;
}

}  // namespace octant
