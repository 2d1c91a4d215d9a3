// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// A scanner among straight walls.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "models/physics/pose.h"
#include "models/run.h"
#include "models/simulator/random.h"

namespace octant::test {

struct Wall {
  Eigen::Vector2d from_m, to_m;
};

struct Scanner {
  double angle_min_rad = -M_PI / 2;
  double step_rad = M_PI / 180;
  int beams = 181;
  double range_max_m = 30.0;
};

/// Distance along a ray to the nearest wall; infinite if there is none.
inline double range_to(const std::vector<Wall>& walls, const Eigen::Vector2d& from,
                       const Eigen::Vector2d& direction) {
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& w : walls) {
    const Eigen::Vector2d along = w.to_m - w.from_m, to = w.from_m - from;
    const double det = cross(direction, along);
    if (std::abs(det) < 1e-12) continue;
    const double range = cross(to, along) / det, t = cross(to, direction) / det;
    if (range > 1e-6 && t >= 0 && t <= 1) nearest = std::min(nearest, range);
  }
  return nearest;
}

inline Scan scan_of(const std::vector<Wall>& walls, const Pose& T_map_sensor, const Scanner& scanner,
                    double noise_m, Random& random, double time_s = 0.0) {
  Scan scan{.time_s = time_s,
            .angle_min_rad = scanner.angle_min_rad,
            .angle_increment_rad = scanner.step_rad,
            .range_m = {}};
  const double heading = T_map_sensor.heading_rad();
  for (int k = 0; k < scanner.beams; ++k) {
    const double angle = heading + scanner.angle_min_rad + k * scanner.step_rad;
    const double range =
        range_to(walls, T_map_sensor.translation_m.head<2>(), {std::cos(angle), std::sin(angle)});
    const double noise = noise_m * random.normal();
    scan.range_m.push_back(range < scanner.range_max_m ? range + noise
                                                       : std::numeric_limits<double>::quiet_NaN());
  }
  return scan;
}

}  // namespace octant::test
