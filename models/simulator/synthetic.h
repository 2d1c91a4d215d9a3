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

/// A simulated world: the site as its users know it, both recordings with truth, and the true deployment.
struct World {
  Site site;               ///< approximate positions: truth plus noise of the given sigmas
  MeasurementLog run;      ///< for calibration
  MeasurementLog heldout;  ///< for verification
  /// Lateness of each arrival due to an echo; negative: spurious early arrival; 0: direct path [s].
  std::vector<double> run_lateness_s, heldout_lateness_s;
  Deployment truth;  ///< true values, covariance zero (no joint covariance), created 1970-01-01
};

/// Returns kBadInput with the key of an inconsistent value. Called first by simulate().
[[nodiscard]] Result<void> check_scenario(const Scenario& scenario);

/// Simulates a scenario. A seed gives the same world on every platform. A site without noise.tof_sigma_s has
/// no arrivals, only bearings or scans. The time_s of an arrival is the time of reception, echo included, and
/// its pose is that of the vehicle at this time. With two-way ranging the request is sent in the beacon's
/// slot. Truth is exact, every 50 ms of each stop or at the odometry rows of a drive. The error of a measured
/// pose is constant during a stop. Errors are those of check_scenario.
[[nodiscard]] Result<World> simulate(const Scenario& scenario, std::uint64_t seed);

}  // namespace octant
