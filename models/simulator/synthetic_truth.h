// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/deployment.h"
#include "models/simulator/random.h"
#include "models/simulator/scenario.h"
#include "models/trajectory/shared_state.h"

namespace octant {

/// The true values of everything that calibration solves for.
[[nodiscard]] SharedState draw_truth(const Scenario& scenario, Random& draws);

/// The site as people know it: approximate beacons, nominal receivers, taped distances.
[[nodiscard]] Site known_site(const Scenario& scenario, const SharedState& truth, Random& draws);

/// The deployment that a perfect calibration would write.
[[nodiscard]] Deployment true_deployment(const Scenario& scenario, const SharedState& truth,
                                         std::size_t arrivals);

inline constexpr double kTruthPeriod_s = 0.05;  ///< of stops

/// Longest time for which a stop's arrivals may keep coming, from the start of its epoch, in whole
/// kTruthPeriod_s [s].
[[nodiscard]] double dwell_s(const Scenario& scenario, const Scenario::Path& path);

}  // namespace octant
