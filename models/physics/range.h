// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/physics/attenuation.h"

namespace octant {

/// Ratio of threshold to predicted amplitude above which the walk is bounded. A state under test may lie
/// where the signal is too weak, and its cost must remain finite there.
inline constexpr double kMostPredictedShare = 0.995;

/// Delay of the threshold crossing for a given ratio of threshold to amplitude, below 1 [s].
[[nodiscard]] double walk_of_share_s(double share, const AttenuationModel& model);

/// Time of flight and the parts of it that are not due to distance: delays, turnaround time, cycle offset.
struct FlightTime {
  double time_s = 0.0;
  double speed_mps = 343.0;
  double legs = 1.0;  ///< 2 for a round trip
};

/// One-way range that corresponds to a time of flight.
struct TimedRange {
  double range_m = 0.0;
  double by_time_mps = 0.0;  ///< derivative of the range by the time of flight
};

/// Solves the measurement equation for the distance d: legs d + c walk(d) = c time. The walk is that of the
/// amplitude predicted at d on the receiver's axis, bounded as kMostPredictedShare says. The solution is
/// unique and exact to rounding. A time that no distance explains gives the range without walk. Does not
/// allocate.
/// @param log_gain  natural logarithm of the beacon's amplitude relative to the model
[[nodiscard]] TimedRange range_with_walk(const FlightTime& flight, const AttenuationModel& model,
                                         double log_gain) noexcept;

/// Additional delay of a pulse at a receiver that is turned away from it by the half-power angle, compared
/// with one on the axis [s]. Serves as the sigma of the walk where the angle is unknown.
[[nodiscard]] double off_axis_walk_sigma_s(double distance_m, const AttenuationModel& model,
                                           double log_gain) noexcept;

}  // namespace octant
