// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "models/deployment.h"
#include "models/run.h"
#include "models/simulator/scenario.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant {

/// A simulated world: the site as people would know it, both recordings with truth, and the true deployment.
struct World {
  Site site;               ///< approximate positions: truth plus noise of the stated sigmas
  MeasurementLog run;      ///< for calibration
  MeasurementLog heldout;  ///< for verification
  /// How late each arrival is through an echo; negative: spurious early; 0: direct [s].
  std::vector<double> run_lateness_s, heldout_lateness_s;
  Deployment truth;  ///< true values, covariance zero (no joint covariance), created 1970-01-01
};

/// kBadInput, naming the key, where a scenario contradicts itself. simulate() begins with it.
[[nodiscard]] Result<void> check_scenario(const Scenario& scenario);

/// Simulates a scenario; the same world for a seed everywhere. A site without noise.tof_sigma_s has no
/// arrivals (bearings or scans alone). Errors: those of check_scenario. time_s of an arrival is the instant
/// of hearing, echo included; a drive's arrival belongs to the pose at that instant (two-way ranging: the
/// vehicle asks in the beacon's slot and hears the reply at time_s). Truth is exact, every 50 ms of each stop
/// or at the odometry rows of a drive. A stop's measured pose keeps its one error for the whole stop.
[[nodiscard]] Result<World> simulate(const Scenario& scenario, std::uint64_t seed);

}  // namespace octant
