// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/live/live_speed.h"

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
  if (asked_ == nullptr) {
    if (kept_.arrivals.size() >= wanted_) begin();
    return std::nullopt;
  }
  if (kept_.arrivals.size() < asked_->arrivals.size()) return std::nullopt;
  const RunSpeed found = estimate_.get();
  const auto of = std::exchange(asked_, nullptr);
  if (!found.determined && wanted_ < kMostKept) {
    wanted_ *= 2;
    kept_.arrivals.insert(kept_.arrivals.begin(), of->arrivals.begin(), of->arrivals.end());
    kept_.odometry.insert(kept_.odometry.begin(), of->odometry.begin(), of->odometry.end());
    kept_.has_epochs = kept_.has_epochs || of->has_epochs;
  } else {
    wanted_ = kMostKept;
  }
  if (kept_.arrivals.size() >= wanted_) begin();
  return found.determined ? std::optional(found) : std::nullopt;
}

void LiveSpeed::begin() {
  const auto rows = std::make_shared<const MeasurementLog>(std::exchange(kept_, {}));
  if (!speed_is_unknown(*calibrated_, *rows)) {
    wanted_ = kMostKept;
    return;
  }
  asked_ = rows;
  const auto make = [of = calibrated_, rows] { return estimate_run_speed(*of, *rows); };
  try {
    estimate_ = std::async(std::launch::async, make);
  } catch (const std::system_error&) {  // no thread is to be had: when it is looked at
    estimate_ = std::async(std::launch::deferred, make);
  }
}

}  // namespace octant
