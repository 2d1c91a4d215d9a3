// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/stream/log_readings.h"

namespace octant::calib {

/// Plain squares on the arrivals that agree, by Newton's method on the sums that readings leave: near the
/// optimum cost, gradient and Gauss-Newton matrix are all there is to know, so one reading is one step.
/// Arrivals are rejected and readmitted by the way, and three or four readings are enough. A step that makes
/// things worse is taken back, and from then on marks change only where the adjustment has settled.
/// @param frame  priors and taped distances, which each step takes as they are
/// @param first  of a reading at the estimate, if it is known
/// @return the last reading
[[nodiscard]] Result<PassSum> newton_steps(LogReadings& readings, const Problem& frame,
                                           const SolveOptions& options, ProgressMonitor& monitor,
                                           std::optional<PassSum> first, Estimate& estimate);

}  // namespace octant::calib
