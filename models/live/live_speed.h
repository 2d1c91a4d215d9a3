// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "models/deployment.h"
#include "models/localizers/speed/run_speed.h"
#include "models/run.h"

namespace octant {

/// The speed of a live stream at an unknown temperature, again and again as the air changes: rows are kept
/// until they tell it, at most some thousands, as run_speed.h has it for a recording. Rows whose arrivals
/// state temperatures at which the deployment is valid cost nothing but their memory.
class LiveSpeed {
 public:
  explicit LiveSpeed(Deployment calibrated);

  void hear(const Arrival& arrival);
  void move(const OdometryStep& step);
  /// Whether so many arrivals were kept that an estimate may be made of them.
  [[nodiscard]] bool ready() const { return kept_.arrivals.size() >= wanted_; }
  /// Of the arrivals kept, some tenths of a second; none where the temperature is known or they do not tell
  /// it yet. Then more are waited for, up to a limit; else all begins anew.
  [[nodiscard]] std::optional<RunSpeed> estimate();
  [[nodiscard]] const Deployment& calibrated() const { return calibrated_; }

 private:
  Deployment calibrated_;
  MeasurementLog kept_;
  std::size_t wanted_;
};

}  // namespace octant
