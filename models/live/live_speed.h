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

/// The speed of a live stream at an unknown temperature, again and again as the air changes: rows are kept
/// until they tell it, at most some thousands, as run_speed.h has it for a recording. Rows whose arrivals
/// state temperatures at which the deployment is valid cost nothing but their memory.
///
/// An estimate takes some tenths of a second, which no fix waits for: a thread makes it while as many
/// arrivals come as it is made of and seconds pass by the stream's own clock, and only then it is looked at.
/// So what a stream is told, and when, hangs on the stream alone, not on who was faster. Air changes over
/// minutes: a stream of thousands of arrivals a second rests in between, and its rows are not kept then.
class LiveSpeed {
 public:
  explicit LiveSpeed(const Deployment& calibrated);

  void hear(const Arrival& arrival);
  void move(const OdometryStep& step);
  /// Between two poses: begins an estimate, or looks at one, if it is time for that.
  /// @return an estimate that tells the speed, once
  [[nodiscard]] std::optional<RunSpeed> new_estimate();
  [[nodiscard]] const Deployment& calibrated() const { return *calibrated_; }

 private:
  void begin();
  [[nodiscard]] bool passed(double span_s) const;
  [[nodiscard]] bool keeps_rows() const;

  std::shared_ptr<const Deployment> calibrated_;
  MeasurementLog kept_;                          ///< since the estimate that runs was begun
  std::size_t wanted_;                           ///< arrivals, from which the next estimate is made
  std::shared_ptr<const MeasurementLog> asked_;  ///< of which the estimate that runs is made; null: none runs
  std::future<RunSpeed> estimate_;
  bool rests_ = false;     ///< told a short time ago
  double now_s_ = 0.0;     ///< by the stream's clock
  double begun_s_ = 0.0;   ///< the last estimate
  std::size_t heard_ = 0;  ///< arrivals since then
};

}  // namespace octant
