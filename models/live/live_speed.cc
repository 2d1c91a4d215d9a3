// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/live/live_speed.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

namespace octant {
namespace {

constexpr std::size_t kFirstEstimate = 400, kMostKept = 3'200;  ///< numbers of arrivals
constexpr double kThought_s = 2.0;                              ///< least time for an estimate
constexpr double kBetween_s = 10.0;          ///< from the start of an estimate to the rows of the next
constexpr std::size_t kMostHeard = 100'000;  ///< number of arrivals after which a stopped clock is ignored

}  // namespace

LiveSpeed::LiveSpeed(const Deployment& calibrated)
    : calibrated_(std::make_shared<const Deployment>(calibrated)), wanted_(kFirstEstimate) {}

void LiveSpeed::hear(const Arrival& arrival) {
  now_s_ = arrival.time_s;
  ++heard_;
  rests_ = rests_ && !passed(kBetween_s);
  if (!keeps_rows()) return;
  kept_.arrivals.push_back(arrival);
  kept_.has_epochs = kept_.has_epochs || arrival.epoch != kNoEpoch;
}

void LiveSpeed::move(const OdometryStep& step) {
  if (keeps_rows() && kept_.odometry.size() < 32 * kMostKept) kept_.odometry.push_back(step);
}

std::optional<RunSpeed> LiveSpeed::new_estimate() {
  if (asked_ == nullptr) {
    if (kept_.arrivals.size() >= wanted_) begin();
    return std::nullopt;
  }
  const std::size_t as_many = std::min(asked_->arrivals.size(), kMostKept);
  if (kept_.arrivals.size() < as_many || !passed(kThought_s)) return std::nullopt;
  const RunSpeed found = estimate_.get();
  const auto of = std::exchange(asked_, nullptr);
  if (!found.determined && wanted_ < kMostKept) {
    wanted_ *= 2;
    kept_.arrivals.insert(kept_.arrivals.begin(), of->arrivals.begin(), of->arrivals.end());
    kept_.odometry.insert(kept_.odometry.begin(), of->odometry.begin(), of->odometry.end());
    kept_.has_epochs = kept_.has_epochs || of->has_epochs;
  } else {
    wanted_ = kMostKept;
    rests_ = !passed(kBetween_s);
    if (rests_) kept_ = {};
  }
  if (kept_.arrivals.size() >= wanted_) begin();
  return found.determined ? std::optional(found) : std::nullopt;
}

/// Returns true after a time span, and immediately if the clock is set back.
bool LiveSpeed::passed(double span_s) const {
  return std::abs(now_s_ - begun_s_) >= span_s || heard_ >= kMostHeard;
}

bool LiveSpeed::keeps_rows() const { return !rests_ && kept_.arrivals.size() < kMostKept; }

void LiveSpeed::begin() {
  begun_s_ = now_s_;
  heard_ = 0;
  const auto rows = std::make_shared<const MeasurementLog>(std::exchange(kept_, {}));
  if (!speed_is_unknown(*calibrated_, *rows)) {
    wanted_ = kMostKept;
    return;
  }
  asked_ = rows;
  const auto make = [of = calibrated_, rows] { return estimate_run_speed(*of, *rows); };
  try {
    estimate_ = std::async(std::launch::async, make);
  } catch (const std::system_error&) {  // no thread is available: compute it when the result is checked
    estimate_ = std::async(std::launch::deferred, make);
  }
}

}  // namespace octant
