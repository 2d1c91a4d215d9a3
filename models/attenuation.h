// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/result.h"

namespace octant {

/// How a pulse weakens with distance and how late a threshold crossing therefore comes.
///   A(d) = A_1m / d * exp(-alpha d)        (spherical spreading and absorption)
///   walk = -tau ln(1 - V_th / A)           (first-order envelope)
struct AttenuationModel {
  double amplitude_1m_v = 1.0;
  double absorption_np_per_m = 0.0;
  double threshold_v = 0.0;
  double rise_time_s = 0.0;  ///< time constant tau of the envelope; the 10-90 % rise is 2.197 tau
};

/// Plateau amplitude at a distance [V]. @param distance_m > 0
[[nodiscard]] double amplitude_v(double distance_m, const AttenuationModel& model);

/// Delay of a threshold crossing behind the true onset of a pulse with a first-order envelope.
///   t = -tau ln(1 - V_th / A)                                             (derivation: models/README.md)
/// @param amplitude_v  plateau amplitude A at the receiver [V], above threshold_v
/// @return s; Errc::kNotHeard when A <= V_th. Exact for the model.
[[nodiscard]] Result<double> time_walk_s(double amplitude_v, const AttenuationModel& model);

}  // namespace octant
