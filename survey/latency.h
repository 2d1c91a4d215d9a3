// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "models/fix.h"
#include "models/run.h"

namespace octant::survey {

/// Latency of fixes: time from the instant of a fix until the last arrival of its epoch, or of its instant,
/// was received. The time to compute a fix (microseconds) is not included. Fixes without a logged reception
/// have none.
/// @param log  recording from which the fixes were computed
[[nodiscard]] std::vector<double> latencies_s(std::span<const Fix> fixes, const MeasurementLog& log);

}  // namespace octant::survey
