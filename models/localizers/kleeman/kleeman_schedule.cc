// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_schedule.h"

#include <algorithm>
#include <cmath>

namespace octant {

double shortest_fire_s(const FiringDesign& d) {
  return d.amplitude_1m_v * std::pow(1 - d.absorbed_fraction, d.reflections) /
         (d.threshold_v * d.speed_mps);  // eq. 1
}

double least_absorbed_fraction(const FiringDesign& d, double fire_s) {
  if (d.reflections == 0) return 0.0;
  return std::max(0.0,
                  1 - std::pow(fire_s * d.threshold_v * d.speed_mps / d.amplitude_1m_v, 1.0 / d.reflections));
}

}  // namespace octant
