// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/attenuation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace octant {

LogDirectivity log_directivity(double cosine, double half_power_angle_rad) {
  constexpr double kLogHalfPower = -std::numbers::ln2 / 2;  // ln(1 / sqrt 2)
  constexpr double kBehind = 1e-6;                          // bound of (1 + cos) / 2 = cos^2(theta / 2)
  const double tangent = std::tan(half_power_angle_rad / 2);
  const double scale = -std::log1p(tangent * tangent);  // ln((1 + cos h) / 2)
  const double m = kLogHalfPower / scale, share = (1 + cosine) / 2,
               log_share = std::log(std::max(share, kBehind));
  LogDirectivity out;
  out.value = m * log_share;
  out.by_cosine = share > kBehind ? m / (1 + cosine) : 0.0;
  out.by_half_power_angle =
      log_share * m * tangent / scale;  // dm/dh = -m / scale dscale/dh, dscale/dh = -tan(h / 2)
  return out;
}

double amplitude_v(double distance_m, const AttenuationModel& model) {
  return model.amplitude_1m_v / distance_m * std::exp(-model.absorption_np_per_m * distance_m);
}

double walk_by_log_amplitude_s(double amplitude_v, const AttenuationModel& model) {
  const double share = std::min(model.threshold_v / amplitude_v, kMostMeasuredShare);
  return model.rise_time_s * share / (1 - share);
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
