// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/problem/parameters.h"
#include "calib/problem/problem.h"
#include "calib/problem/subsample.h"
#include "calib/sums/ranks.h"

namespace octant::calib {

/// Returns true if a part of a log is sufficient for a start: many thousands of planar stops, or of arrivals
/// on chains of odometry in the plane, or both; no measured poses.
[[nodiscard]] bool is_long(const Problem& problem);
/// Returns true if all its trajectories are stops.
[[nodiscard]] bool has_stops_alone(const Problem& problem);

/// Size of that part of a long log.
inline constexpr SubsampleOptions kLongLogSubsample = {.instants = 600, .per_beacon = 200};

/// A problem with evenly spread epochs of a long log, enough of each beacon (see thin).
[[nodiscard]] Result<Problem> subsample_of(const Problem& problem, int threads = 1);
/// Places all states of a long log whose shared parameters are known but for the noise, stops and drives.
void place_all(const Problem& problem, const ParameterLayout& layout, const SharedState& state,
               const std::vector<bool>& beacon_usable, double suspect_sigmas, const Workers& workers,
               std::vector<Trajectory>& trajectories);

/// Places all states of long drives whose shared parameters are known but for the noise, as `localize` does;
/// those of measured poses are solved. Marks all arrivals used.
void place_all_drives(const Problem& problem, const SharedState& state,
                      const std::vector<bool>& beacon_usable, int threads,
                      std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
