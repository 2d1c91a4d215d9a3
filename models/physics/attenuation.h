// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "models/support/result.h"

namespace octant {

/// Valid half-power angles. No transducer is narrower, and a wider pattern has no direction.
inline constexpr double kLeastHalfPowerAngle_rad = 0.02, kMostHalfPowerAngle_rad = 2.8;

/// Decay of a pulse with distance and off a receiver's axis, and the resulting delay of the threshold
/// crossing.
///   A(d, theta) = A_1m / d exp(-alpha d) D(theta)   spherical spreading, absorption, directivity
///   D(theta) = ((1 + cos theta) / 2)^m              1 / sqrt 2 (3 dB down) at the half-power angle
///   walk = -tau ln(1 - V_th / A)                    first-order envelope
struct AttenuationModel {
  double amplitude_1m_v = 1.0;  ///< on the receiver's axis
  double absorption_np_per_m = 0.0;
  double threshold_v = 0.0;
  double rise_time_s = 0.0;           ///< time constant tau of the envelope; the 10-90 % rise is 2.197 tau
  double half_power_angle_rad = 0.0;  ///< angle off the axis, within the bounds above; 0: receivers are
                                      ///< omnidirectional, like those without an axis
  double saturation_v = std::numeric_limits<double>::infinity();  ///< amplitudes at or above it saturate the
                                                                  ///< receiver and are not measurements

  [[nodiscard]] bool directional() const { return half_power_angle_rad > 0; }
  /// Returns true if a logged amplitude measures the pulse: it is present and did not saturate the receiver.
  [[nodiscard]] bool measures(double logged_v) const { return logged_v > 0 && logged_v < saturation_v; }
};

/// Parameters that calibration may estimate, in this order: amplitude_1m_v, absorption_np_per_m, rise_time_s,
/// half_power_angle_rad.
inline constexpr std::size_t kAttenuationUnknowns = 4;
/// @tparam Attenuation  AttenuationModel, or the AttenuationPrior of a site
template <class Attenuation>
[[nodiscard]] auto& attenuation_unknown(Attenuation& attenuation, std::size_t unknown) {
  switch (unknown) {
    case 0: return attenuation.amplitude_1m_v;
    case 1: return attenuation.absorption_np_per_m;
    case 2: return attenuation.rise_time_s;
    default: return attenuation.half_power_angle_rad;
  }
}

/// Logarithm of the directivity, ln D, and its derivatives. D decreases monotonically towards the back and
/// has no side lobes. Small piezo receivers behave like this in front, where they receive. ln D is bounded
/// within a thousandth of the direction straight behind, where it would tend to minus infinity.
struct LogDirectivity {
  double value = 0.0;
  double by_cosine = 0.0;  ///< by the cosine of the angle off the axis
  double by_half_power_angle = 0.0;
};
/// @param cosine  cosine of the angle off the axis
/// @param half_power_angle_rad  in (0, pi)
[[nodiscard]] LogDirectivity log_directivity(double cosine, double half_power_angle_rad);

/// Plateau amplitude at a distance on the axis [V]. @param distance_m > 0
[[nodiscard]] double amplitude_v(double distance_m, const AttenuationModel& model);

/// Upper bound on the ratio of the threshold to a measured amplitude: an amplitude measured at or below the
/// threshold is noise.
inline constexpr double kMostMeasuredShare = 0.95;

/// Derivative of the delay by minus the logarithm of a measured amplitude: tau s / (1 - s) with s = V_th / A,
/// bounded by kMostMeasuredShare [s].
[[nodiscard]] double walk_by_log_amplitude_s(double amplitude_v, const AttenuationModel& model);

/// Delay of a threshold crossing after the onset of a pulse with a first-order envelope:
///   t = -tau ln(1 - V_th / A)                                             (derivation: models/README.md)
/// @param amplitude_v  plateau amplitude A at the receiver [V], above threshold_v
/// @return delay [s]; Errc::kNotHeard when A <= V_th. Exact for the model.
[[nodiscard]] Result<double> time_walk_s(double amplitude_v, const AttenuationModel& model);

}  // namespace octant
