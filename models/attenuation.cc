// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/attenuation.h"

#include <cmath>

namespace octant {

double amplitude_v(double distance_m, const AttenuationModel& model) {
  return model.amplitude_1m_v / distance_m * std::exp(-model.absorption_np_per_m * distance_m);
}

Result<double> time_walk_s(double amplitude_v, const AttenuationModel& model) {
  if (!(amplitude_v > model.threshold_v)) {
    return fail({.code = Errc::kNotHeard,
                 .found = "amplitude " + std::to_string(amplitude_v) + " V",
                 .expected = "more than the threshold of " + std::to_string(model.threshold_v) + " V"});
  }
  return -model.rise_time_s * std::log1p(-model.threshold_v / amplitude_v);
}

}  // namespace octant
