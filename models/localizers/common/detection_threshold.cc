// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/detection_threshold.h"

#include <algorithm>
#include <cmath>

namespace octant {

double detection_voltage_v(double distance_m, double rest_v, double reach_v, double absorption_np_per_m) {
  return rest_v - reach_v * std::exp(-absorption_np_per_m * distance_m);  // eq. 15
}

AlterableThreshold alterable_threshold(const AttenuationModel& model, double reference_m, double least_v) {
  return {.model = model, .share = model.threshold_v / amplitude_v(reference_m, model), .least_v = least_v};
}

double threshold_v(double distance_m, const AlterableThreshold& threshold) {
  return std::max(threshold.least_v, threshold.share * amplitude_v(distance_m, threshold.model));
}

Result<double> crossing_time_s(double distance_m, double level_v, const AttenuationModel& model,
                               double speed_mps) {
  AttenuationModel at_level = model;
  at_level.threshold_v = level_v;
  const Result<double> walk_s = time_walk_s(amplitude_v(distance_m, model), at_level);
  if (!walk_s) return fail(walk_s.error());
  return distance_m / speed_mps + *walk_s;
}

double range_without_compensation_m(double crossing_s, double speed_mps) { return speed_mps * crossing_s; }

double range_with_compensation_m(double crossing_s, double speed_mps, const AlterableThreshold& threshold) {
  const double level_walk_s = -threshold.model.rise_time_s * std::log1p(-threshold.share);
  return speed_mps * (crossing_s - level_walk_s);
}

}  // namespace octant
