// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/run.h"
#include "models/simulator/random.h"
#include "models/simulator/scenario.h"
#include "models/simulator/synthetic_path.h"
#include "models/support/result.h"
#include "models/trajectory/shared_state.h"

namespace octant {

/// Adds the bearings and laser scans of the scenario to a recorded run, at the start of each stop or
/// periodically along a drive. `draws` is a separate stream, so the other contents of the run do not change.
void record_sensors(const Scenario& scenario, const Scenario::Path& spec, const TruePath& path,
                    const SharedState& truth, Random draws, MeasurementLog& log);

/// Returns kBadInput for inconsistent walls, bearings or scans. Part of check_scenario.
[[nodiscard]] Result<void> check_sensors(const Scenario& scenario);

}  // namespace octant
