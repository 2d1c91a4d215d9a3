// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// What the states of a vehicle in a run are, and so which of them hang together by more than what all share.
enum class StateKind {
  kStops,         ///< an epoch each, each for itself
  kChainedStops,  ///< an epoch each, odometry between them
  kDrive,         ///< at odometry rows, all of them a chain
  kMotion,        ///< at instants of arrivals, tied by a motion prior until the vehicle is silent
  kMoments        ///< at instants of arrivals, each for itself; where there are measured poses, with one
};

/// As make_trajectory builds them, of a vehicle that has arrivals.
[[nodiscard]] StateKind state_kind(const MeasurementLog& log, VehicleId vehicle,
                                   const TrajectoryModel& model);

/// Arrivals of one moment: of one time, or heard while the vehicle, whose pose was measured, moved by less
/// than a tenth of what that pose is good to, and of the noise of a range. As states of their own each would
/// have the one error of the pose anew.
/// @param arrivals  indices into the log's, by time  @param first  of them, heard at T
/// @param T  where it was measured to be then; none: arrivals of one time alone
/// @param noise_m  of a range
/// @return behind the last of them
[[nodiscard]] std::size_t end_of_moment(const MeasurementLog& log, const std::vector<std::size_t>& arrivals,
                                        std::size_t first, const Pose* T, double noise_m);

/// No sound takes longer to pass a vehicle.
inline constexpr double kMoment_s = 0.01;
/// After a silence the motion prior says nothing any more.
inline constexpr double kSilence_s = 10.0;
/// Bearings belong to the nearest instant of arrivals, if they are that near.
inline constexpr double kNearInstant_s = 0.05;

/// Arrivals of a vehicle farther apart in time belong to states that do not hang together; 0 for stops, whose
/// epochs tell.
[[nodiscard]] double longest_tie_s(StateKind kind);

}  // namespace octant
