// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/deployment.h"
#include "models/simulator/random.h"
#include "models/simulator/scenario.h"
#include "models/trajectory/shared_state.h"

namespace octant {

/// Draws the true values of everything that calibration estimates.
[[nodiscard]] SharedState draw_truth(const Scenario& scenario, Random& draws);

/// The site as its users know it: approximate beacons, nominal receivers, measured distances.
[[nodiscard]] Site known_site(const Scenario& scenario, const SharedState& truth, Random& draws);

/// The deployment that a perfect calibration would produce.
[[nodiscard]] Deployment true_deployment(const Scenario& scenario, const SharedState& truth,
                                         std::size_t arrivals);

inline constexpr double kTruthPeriod_s = 0.05;  ///< sampling period of the truth during stops

/// Upper bound on the time from the start of an epoch to the last arrival of its stop, rounded up to
/// kTruthPeriod_s [s].
[[nodiscard]] double dwell_s(const Scenario& scenario, const Scenario::Path& path);

}  // namespace octant
