// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_schedule.h"

#include <cmath>

namespace octant {

double shortest_fire_s(const FiringDesign& d) {
  return d.amplitude_1m_v * std::pow(1 - d.absorbed_fraction, d.reflections) /
         (d.threshold_v * d.speed_mps);  // eq. 1
}

}  // namespace octant
