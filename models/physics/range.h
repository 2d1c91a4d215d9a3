// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/physics/attenuation.h"

namespace octant {

/// Share of the threshold in a predicted amplitude beyond which the logarithm of the walk is held: a state
/// under test may lie where nothing would be heard, and its cost must stay finite there.
inline constexpr double kMostPredictedShare = 0.995;

/// How late a crossing comes whose threshold is such a share of the amplitude, below 1 [s].
[[nodiscard]] double walk_of_share_s(double share, const AttenuationModel& model);

/// A time of flight less all that is not the way: delays, a turnaround, the offset of a cycle.
struct FlightTime {
  double time_s = 0.0;
  double speed_mps = 343.0;
  double legs = 1.0;  ///< 2: there and back
};

/// One way.
struct TimedRange {
  double range_m = 0.0;
  double by_time_mps = 0.0;  ///< range per second of time of flight
};

/// The distance at which the measurement equation gives a time of flight: legs d + c walk(d) = c time, the
/// walk that of the amplitude predicted at d on the receiver's axis, held beyond kMostPredictedShare. It has
/// one solution, found to rounding; a time that is none gives what it would without a walk. Allocates
/// nothing.
/// @param log_gain  of the beacon's amplitude over the model's, ln
[[nodiscard]] TimedRange range_with_walk(const FlightTime& flight, const AttenuationModel& model,
                                         double log_gain) noexcept;

/// How much later a pulse from that distance comes to a receiver off whose axis it is by the half-power
/// angle: the sigma of a walk where the angle is not known [s].
[[nodiscard]] double off_axis_walk_sigma_s(double distance_m, const AttenuationModel& model,
                                           double log_gain) noexcept;

}  // namespace octant
