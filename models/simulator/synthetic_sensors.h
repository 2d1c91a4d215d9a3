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

/// Adds bearings to reflectors and laser scans to a recorded run, as the scenario asks for; nothing where it
/// does not. Both come once a stop, at its start, or at their period along a drive. `draws` is a stream of
/// its own: what else the run holds stays.
void record_sensors(const Scenario& scenario, const Scenario::Path& spec, const TruePath& path,
                    const SharedState& truth, Random draws, MeasurementLog& log);

/// kBadInput where walls, bearings or scans contradict themselves; the part of check_scenario that concerns
/// them.
[[nodiscard]] Result<void> check_sensors(const Scenario& scenario);

}  // namespace octant
