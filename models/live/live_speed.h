// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <future>
#include <memory>
#include <optional>

#include "models/deployment.h"
#include "models/localizers/speed/run_speed.h"
#include "models/run.h"

namespace octant {

/// Estimates the speed of a live stream at an unknown temperature, repeatedly as the temperature changes.
/// Rows are kept until they determine it, at most some thousands (run_speed.h). Rows whose arrivals have
/// temperatures at which the deployment is valid cost only their memory.
///
/// An estimate takes some tenths of a second, and a thread computes it, so that no fix waits. Its result is
/// used after as many new arrivals as it was made of and some seconds of the stream's own clock. So the
/// results depend on the stream alone, not on processing speed. Temperature changes over minutes, so with
/// thousands of arrivals a second the estimator pauses in between, and no rows are kept.
class LiveSpeed {
 public:
  explicit LiveSpeed(const Deployment& calibrated);

  void hear(const Arrival& arrival);
  void move(const OdometryStep& step);
  /// Starts an estimate or checks for its result, if it is time for that. Call between two poses.
  /// @return an estimate that determines the speed, once
  [[nodiscard]] std::optional<RunSpeed> new_estimate();
  [[nodiscard]] const Deployment& calibrated() const { return *calibrated_; }

 private:
  void begin();
  [[nodiscard]] bool passed(double span_s) const;
  [[nodiscard]] bool keeps_rows() const;

  std::shared_ptr<const Deployment> calibrated_;
  MeasurementLog kept_;  ///< rows since the start of the current estimate
  std::size_t wanted_;   ///< number of arrivals for the next estimate
  /// Rows of the current estimate; null if there is no current one
  std::shared_ptr<const MeasurementLog> asked_;
  std::future<RunSpeed> estimate_;
  bool rests_ = false;     ///< the last estimate is recent
  double now_s_ = 0.0;     ///< time of the stream's clock
  double begun_s_ = 0.0;   ///< start of the last estimate
  std::size_t heard_ = 0;  ///< number of arrivals since then
};

}  // namespace octant
