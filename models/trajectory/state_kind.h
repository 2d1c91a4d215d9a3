// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Kinds of vehicle states in a run, which determine how the states are linked.
enum class StateKind {
  kStops,         ///< one independent state for each epoch
  kChainedStops,  ///< one state for each epoch, linked by odometry
  kDrive,         ///< one state for each odometry row, in one chain
  kMotion,        ///< one state for each instant of arrivals, linked by a motion prior between silences
  kMoments  ///< one independent state for each instant of arrivals, with its measured pose if there are any
};

/// Kind of the states that make_trajectory builds for a vehicle with arrivals.
[[nodiscard]] StateKind state_kind(const MeasurementLog& log, VehicleId vehicle,
                                   const TrajectoryModel& model);

/// Finds the arrivals that share a moment, and so a state. They have the same time, or the vehicle, whose
/// pose is measured, moves between them by less than a tenth of the pose's sigma and of a range's noise.
/// Separate states would count the one error of the pose several times.
/// @param arrivals  indices into the arrivals of the log, by time  @param first  first arrival of the moment,
/// received at T
/// @param T  measured pose at that time; null: only arrivals of the same time
/// @param noise_m  sigma of a range
/// @return one past the last arrival of the moment
[[nodiscard]] std::size_t end_of_moment(const MeasurementLog& log, const std::vector<std::size_t>& arrivals,
                                        std::size_t first, const Pose* T, double noise_m);

/// Longest time in which sound passes a vehicle.
inline constexpr double kMoment_s = 0.01;
/// Silence after which the motion prior carries no information.
inline constexpr double kSilence_s = 10.0;
/// Longest time between a bearing and the instant of arrivals that it belongs to.
inline constexpr double kNearInstant_s = 0.05;

/// Arrivals of a vehicle that are farther apart in time belong to states that are not linked. 0 for stops,
/// whose epochs separate them.
[[nodiscard]] double longest_tie_s(StateKind kind);

}  // namespace octant
