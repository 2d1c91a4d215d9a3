// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/rail/arc_rail.h"

#include <algorithm>
#include <cmath>

namespace octant {
namespace {

constexpr double kLeastSine =
    0.02;  // of beta: nearer to the turning point the step is fifty times the change of range

/// Angle between sides p and q of a triangle whose third side is r, by the law of cosines.
std::optional<double> angle_between(double p, double q, double r) {
  const double cosine = (p * p + q * q - r * r) / (2 * p * q);
  if (!(std::abs(cosine) <= 1 + 1e-12)) return std::nullopt;
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

}  // namespace

std::optional<ArcAngles> arc_angles(const ArcRail& rail, double d_m) {
  if (!(rail.radius_m > 0 && rail.centre_m > 0 && d_m > 0)) return std::nullopt;
  const auto at_robot = angle_between(rail.radius_m, d_m, rail.centre_m);   // eq. 12
  const auto at_beacon = angle_between(rail.centre_m, d_m, rail.radius_m);  // eq. 13
  if (!at_robot || !at_beacon) return std::nullopt;
  ArcAngles angles;
  angles.beta_rad = *at_robot;
  angles.phi_rad = *at_beacon - M_PI / 2;
  angles.alpha_rad = M_PI / 2 - angles.phi_rad - angles.beta_rad;  // eq. 11
  return angles;
}

Eigen::Vector2d arc_position_m(const ArcState& state) {
  return {-state.d_m * std::cos(state.phi_rad), state.d_m * std::sin(state.phi_rad)};  // eq. 8
}

std::optional<ArcState> arc_step(const ArcRail& rail, const ArcState& state, double d_next_m) {
  const std::optional<ArcAngles> angles = arc_angles(rail, state.d_m);
  if (!angles || !(std::abs(std::sin(angles->beta_rad)) > kLeastSine)) return std::nullopt;
  const double phi = state.phi_rad, alpha = angles->alpha_rad;
  const Eigen::Vector2d direction(std::cos(alpha), std::sin(alpha));  // eq. 7 for v_n = 1
  // eq. 10 (the inverse of eq. 9), rows of Delta d and Delta phi.
  const Eigen::RowVector2d d_row(-std::cos(phi), std::sin(phi));
  const Eigen::RowVector2d phi_row = Eigen::RowVector2d(std::sin(phi), std::cos(phi)) / state.d_m;
  const double delta_d_m = d_next_m - state.d_m;
  const double travel_m = delta_d_m / (d_row * direction).value();  // T v_n
  const double delta_phi_rad = travel_m * (phi_row * direction).value();
  return ArcState{state.d_m + delta_d_m, phi + delta_phi_rad};  // eq. 14
}

}  // namespace octant
