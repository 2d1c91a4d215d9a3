// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "models/ids.h"

namespace octant {

// L. Kleeman, "Ultrasonic autonomous robot localisation system", section 2: the beacons fire cyclically one
// after the other. Beacon 0 fires twice in short succession, so that the receiver can identify the beacons.

/// Pulses of one cycle. Defaults: the prototype.
struct FiringSchedule {
  int beacons = 6;           ///< 3 to 16
  double fire_s = 0.150;     ///< t_fire, between the firings of successive beacons
  double pulse_s = 2.5e-3;   ///< t_pulse, length of a pulse
  double double_s = 5.5e-3;  ///< t_double, from the start of beacon 0's first pulse to that of its second
};

/// Time from one firing of a beacon to its next [s].
[[nodiscard]] inline double cycle_s(const FiringSchedule& schedule) {
  return schedule.beacons * schedule.fire_s;
}

/// Time at which a beacon fires, from the start of cycle 0 [s].
[[nodiscard]] inline double firing_s(const FiringSchedule& schedule, BeaconId beacon, std::int64_t epoch) {
  return (static_cast<double>(epoch) * schedule.beacons + beacon.value) * schedule.fire_s;
}

/// Parameters that determine the time between firings. Defaults: the prototype.
struct FiringDesign {
  double amplitude_1m_v = 12.5;    ///< V_1m, at a receiver 1 m in front of the beacon
  double threshold_v = 0.2;        ///< V_thresh
  double absorbed_fraction = 0.0;  ///< alpha: loss of amplitude at each reflection
  int reflections = 0;             ///< n: number of reflections until the next firing
  double speed_mps = 345.0;        ///< v_sound
};

/// Shortest time between firings after which echoes of a pulse are below the threshold (eq. 1):
///   t_fire > V_1m (1 - alpha)^n / (V_thresh v_sound)
/// The amplitude is inversely proportional to the distance, which is t_fire v_sound for the echo. An echo
/// received after the next firing would be mistaken for an early pulse of the next beacon, and the method
/// relies on the absence of early pulses.
/// @return s; 416 ms for a threshold of 87 mV without absorption. (The paper prints 480 ms, which its
/// equation gives for 300 m/s, not for its 345 m/s.)
[[nodiscard]] double shortest_fire_s(const FiringDesign& design);

}  // namespace octant
