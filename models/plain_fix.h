// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/fix.h"

namespace octant {

/// Writes a fix into a row of plain numbers with Octant's field names (x_m, qx, sigma_x_m ...), for other
/// languages and for programs without Eigen.
/// @return true if there is a fix; otherwise pose, velocity, sigmas and protection level of the row are left
/// unchanged; the velocity also if it is unknown
template <class Row>
bool fill_row(const Fix& fix, Row& row) {
  row.ok = fix.ok();
  row.time_s = fix.time_s;
  row.vehicle = fix.vehicle.value;
  row.arrivals_used = fix.arrivals_used;
  row.arrivals_rejected = fix.arrivals_rejected;
  if (!fix.ok()) return false;
  const auto& p = fix.T_map_vehicle.translation_m;
  const auto& q = fix.T_map_vehicle.rotation;
  const auto sigma = [&](int i) { return std::sqrt(std::max(fix.covariance(i, i), 0.0)); };
  row.x_m = p.x();
  row.y_m = p.y();
  row.z_m = p.z();
  row.heading_rad = fix.T_map_vehicle.heading_rad();
  row.qx = q.x();
  row.qy = q.y();
  row.qz = q.z();
  row.qw = q.w();
  row.sigma_x_m = sigma(0);
  row.sigma_y_m = sigma(1);
  row.sigma_heading_rad = std::min(sigma(fix.covariance.rows() == 6 ? 5 : 2), std::numbers::pi);
  row.protection_level_m = fix.protection_level_m;
  Eigen::Map<Eigen::Matrix<double, 6, 6>>(&row.covariance[0][0]) =
      covariance_in_map(fix.covariance, fix.T_map_vehicle);
  if (!fix.velocity) return true;
  const Velocity velocity_sigma = fix.velocity->variance.cwiseSqrt();
  for (int i = 0; i < 3; ++i) {
    row.velocity_mps[i] = fix.velocity->mean[i];
    row.turn_rate_radps[i] = fix.velocity->mean[3 + i];
    row.sigma_velocity_mps[i] = velocity_sigma[i];
    row.sigma_turn_rate_radps[i] = velocity_sigma[3 + i];
  }
  return true;
}

}  // namespace octant
