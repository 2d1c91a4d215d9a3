// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/physics/attenuation.h"

namespace octant {

/// Chang eq. 15, V = V0 - A0 e^(-a x): the level at which a receiver's comparator detects a pulse from a
/// distance x. As it stands V rises with the distance while the pulse weakens. It is the level of a
/// comparator that rests at V0 and that a pulse pulls down: what a pulse has to reach, V0 - V = A0 e^(-a x),
/// falls like the pulse's own amplitude, and so a threshold crossing comes equally late at any distance.
/// @param rest_v  V0  @param reach_v  A0, what a pulse has to reach at x = 0  @param absorption_np_per_m  a
[[nodiscard]] double detection_voltage_v(double distance_m, double rest_v, double reach_v,
                                         double absorption_np_per_m);

/// Threshold that is lowered in step with the amplitude that a calibrated site predicts
/// (models/physics/attenuation.h, spreading included, which eq. 15 leaves out), so that time-walk stays
/// level. A receiver knows the distance before the pulse is there: it is the time since the firing times the
/// speed.
struct AlterableThreshold {
  AttenuationModel model;
  double share = 0.0;    ///< of the amplitude: threshold over amplitude, below 1
  double least_v = 0.0;  ///< noise forbids a lower threshold; beyond the distance where it begins to hold the
                         ///< walk grows again
};

/// The share that the model's own fixed threshold has at a reference distance: there both are the same.
[[nodiscard]] AlterableThreshold alterable_threshold(const AttenuationModel& model, double reference_m,
                                                     double least_v = 0.0);

/// Threshold for a distance [V].
[[nodiscard]] double threshold_v(double distance_m, const AlterableThreshold& threshold);

/// Time from firing to the crossing of a threshold; Errc::kNotHeard where the pulse does not reach it.
[[nodiscard]] Result<double> crossing_time_s(double distance_m, double threshold_v,
                                             const AttenuationModel& model, double speed_mps);

/// Distance from a crossing time. Without compensation the walk stays in it, and grows with the distance; an
/// altered threshold makes the walk one constant, which is taken off.
[[nodiscard]] double range_without_compensation_m(double crossing_s, double speed_mps);
[[nodiscard]] double range_with_compensation_m(double crossing_s, double speed_mps,
                                               const AlterableThreshold& threshold);

}  // namespace octant
