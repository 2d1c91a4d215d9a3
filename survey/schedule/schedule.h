// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace octant::survey {

/// Quantities that determine the reverberation of a pulse in a hall. Amplitudes are those of
/// models/physics/attenuation.h: A_1m / d exp(-alpha d).
struct Reverberance {
  double amplitude_1m_v = 0.0, threshold_v = 0.0;  ///< only their ratio counts
  double absorption_np_per_m = 0.0;                ///< absorption of the air
  double wall_reflection =
      0.96;  ///< reflection of the amplitude at each wall; 0.96 reproduces Kleeman's 150 ms
  double volume_m3 = 0.0, surface_m2 = 0.0;  ///< volume of the hall; surface of floor, ceiling and walls
  double longest_m = 0.0;                    ///< longest straight line within it
  double pulse_s = 2.5e-3;                   ///< length of a pulse
  double speed_mps = 343.0;
};

/// Times from the firing of a pulse until it is below the threshold [s].
struct FallSilent {
  /// No single echo is above the threshold any more. A path of length d in a hall whose longest line is D has
  /// met at least ceil(d / D) - 1 walls, so its amplitude is at most A_1m / d exp(-alpha d) R^(ceil(d / D) -
  /// 1): Kleeman's eq. 1 with the number of reflections counted (they grow with the path) and the air's
  /// absorption. Image sources: J. B. Allen, D. A. Berkley, J. Acoust. Soc. Am. 65 (1979) 943.
  double single_echo_s = 0.0;
  /// All echoes together stay below it but for a chance of exp(-9) in a pulse's length. Image sources are 4
  /// pi c^3 t^2 / V a second (H. Kuttruff, Room Acoustics, 4.1), so that with energies R^2 a mean free path
  /// of 4 V / S, as in Eyring's formula,
  ///   A_rms(t)^2 = A_1m^2 4 pi c t_pulse / V exp(-2 alpha c t) R^(2 c t S / 4 V),   3 A_rms(t) =
  ///   V_threshold.
  double all_echoes_s = 0.0;
  /// Kleeman's eq. 1 unchanged: no absorption of the air, and as many reflections as the longest path fits
  /// into the resulting silence.
  double kleeman_s = 0.0;
  /// Reverberation time (60 dB) by Eyring (J. Acoust. Soc. Am. 1 (1930) 217) with the air's absorption.
  double t60_s = 0.0;
  /// Shortest time between firings: the longer of both bounds, and the pulse.
  double slot_s = 0.0;
};
/// @param r  amplitude, threshold, volume, surface, longest line and speed above zero; reflection in [0, 1)
[[nodiscard]] FallSilent fall_silent(const Reverberance& r);

/// Audibility: one row of poses for each beacon.
struct Audience {
  std::vector<std::vector<std::uint8_t>> heard;  ///< 1: the direct pulse
  std::vector<std::vector<double>> distance_m;   ///< straight, walls or not
};

struct ShareOptions {
  double reach_m = 0.0;  ///< no pulse and no echo is received beyond it
  /// Assumes that walls and directional patterns block completely: two beacons that no pose receives both of
  /// may fire together, although an echo may pass around an obstacle.
  bool trust_walls = false;
  /// Two beacons that a pose receives both of may fire together if their arrival times differ by guard_s over
  /// the whole area. A receiver must then distinguish an echo of the near one from the far one by other
  /// means.
  bool by_time = false;
  double guard_s = 5e-3;
  double speed_mps = 343.0;
};

/// Why two beacons may or may not fire together.
enum class Sharing { kConfused, kNeverBoth, kApartInTime };

/// Who fires when.
struct FiringPlan {
  std::size_t beacons = 0;
  std::vector<std::vector<std::size_t>> groups;  ///< beacons that fire together, in the order of their slots
  std::vector<Sharing> sharing;                  ///< beacon-major, beacons by beacons
  std::size_t least_groups =
      0;  ///< number of beacons that interfere pairwise, a lower bound of the number of groups
  double slot_s = 0.0;
  [[nodiscard]] double cycle_s() const { return slot_s * static_cast<double>(groups.size()); }
  [[nodiscard]] double one_by_one_s() const { return slot_s * static_cast<double>(beacons); }
  [[nodiscard]] Sharing between(std::size_t a, std::size_t b) const { return sharing[a * beacons + b]; }
};

/// Groups of beacons that do not interfere at any receiver in the area, by greedy colouring of the graph of
/// those that interfere, the most constrained first (DSATUR: D. Brelaz, Commun. ACM 22 (1979) 251). Ties are
/// resolved by the beacon's number.
[[nodiscard]] FiringPlan share_slots(const Audience& audience, const ShareOptions& options, double slot_s);

}  // namespace octant::survey
