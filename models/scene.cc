// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/physics/attenuation.h"

namespace octant {
namespace {

double table_gain(const BeamPattern& pattern, double angle_rad) {
  const auto& angles = pattern.angle_rad;
  if (angles.empty() || angle_rad > angles.back()) return 0.0;
  const auto next = std::ranges::upper_bound(angles, angle_rad);
  if (next == angles.begin()) return pattern.gain.front();
  if (next == angles.end()) return pattern.gain.back();
  const auto k = static_cast<std::size_t>(next - angles.begin());
  const double part = (angle_rad - angles[k - 1]) / (angles[k] - angles[k - 1]);
  return pattern.gain[k - 1] + part * (pattern.gain[k] - pattern.gain[k - 1]);
}

}  // namespace

double beam_gain(const BeamPattern& pattern, double cosine) {
  const double within = std::clamp(cosine, -1.0, 1.0);
  if (pattern.kind == BeamPattern::Kind::kTable) return table_gain(pattern, std::acos(within));
  if (pattern.half_angle_rad < std::numbers::pi && within < std::cos(pattern.half_angle_rad)) return 0.0;
  if (pattern.kind == BeamPattern::Kind::kCone) return 1.0;
  if (pattern.kind == BeamPattern::Kind::kHalfPower)
    return std::exp(log_directivity(within, pattern.half_power_angle_rad).value);
  return within > 0 ? std::pow(within, pattern.exponent) : 0.0;
}

}  // namespace octant
