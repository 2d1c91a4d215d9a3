// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/stream/log_readings.h"

namespace octant::calib {

/// Least squares on the arrivals that agree, by Newton's method on the sums of passes over the log. Near the
/// optimum, cost, gradient and Gauss-Newton matrix are sufficient, so one pass is one step. Arrivals are
/// rejected and readmitted in the same passes, and three or four passes are enough. A step that increases the
/// cost is undone, and from then on marks change only after convergence.
/// @param frame  priors and taped distances, which each step uses
/// @param first  sums of a pass at the estimate, if known
/// @return the last pass
[[nodiscard]] Result<PassSum> newton_steps(LogReadings& readings, const Problem& frame,
                                           const SolveOptions& options, ProgressMonitor& monitor,
                                           std::optional<PassSum> first, Estimate& estimate);

}  // namespace octant::calib
