// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/live/live_speed.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace octant {
namespace {

constexpr std::size_t kFirstLook = 400, kMostKept = 3'200;  ///< arrivals

}  // namespace

LiveSpeed::LiveSpeed(const Deployment& calibrated)
    : calibrated_(std::make_shared<const Deployment>(calibrated)), wanted_(kFirstLook) {}

void LiveSpeed::hear(const Arrival& arrival) {
  kept_.arrivals.push_back(arrival);
  kept_.has_epochs = kept_.has_epochs || arrival.epoch != kNoEpoch;
}

void LiveSpeed::move(const OdometryStep& step) {
  if (kept_.odometry.size() < 32 * kMostKept) kept_.odometry.push_back(step);
}

std::optional<RunSpeed> LiveSpeed::told() {
  if (asked_ == 0) {
    if (kept_.arrivals.size() >= wanted_) begin();
    return std::nullopt;
  }
  if (kept_.arrivals.size() < 2 * asked_) return std::nullopt;
  const RunSpeed found = estimate_.get();
  const std::size_t of = std::exchange(asked_, 0);
  if (!found.determined && wanted_ < kMostKept) {
    wanted_ *= 2;
  } else {
    forget(of);
    wanted_ = kMostKept;
  }
  if (kept_.arrivals.size() >= wanted_) begin();
  return found.determined ? std::optional(found) : std::nullopt;
}

void LiveSpeed::begin() {
  if (!speed_is_unknown(*calibrated_, kept_)) {
    forget(kept_.arrivals.size());
    wanted_ = kMostKept;
    return;
  }
  asked_ = kept_.arrivals.size();
  const auto make = [of = calibrated_, rows = kept_] { return estimate_run_speed(*of, rows); };
  try {
    estimate_ = std::async(std::launch::async, make);
  } catch (const std::system_error&) {  // no thread is to be had: when it is looked at
    estimate_ = std::async(std::launch::deferred, make);
  }
}

/// The first ones, and the odometry before the others.
void LiveSpeed::forget(std::size_t arrivals) {
  kept_.arrivals.erase(kept_.arrivals.begin(),
                       kept_.arrivals.begin() + static_cast<std::ptrdiff_t>(arrivals));
  kept_.has_epochs = std::any_of(kept_.arrivals.begin(), kept_.arrivals.end(),
                                 [](const Arrival& a) { return a.epoch != kNoEpoch; });
  if (kept_.arrivals.empty()) return kept_.odometry.clear();
  const double from_s = kept_.arrivals.front().time_s;
  std::erase_if(kept_.odometry, [from_s](const OdometryStep& row) { return row.time_s < from_s; });
}

}  // namespace octant
