// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/reflectors/resection.h"

#include <cmath>

#include "models/physics/plane.h"

namespace octant {
namespace {

constexpr double kTiny = 1e-9;  // ratio of the centres' distance to that of the points: danger circle

/// Centre of the circle of all points that see p1 and p2 at an angle, multiplied by the sine of the angle. In
/// this form the circle may degenerate to a line.
Eigen::Vector2d scaled_centre(const Eigen::Vector2d& p1, const Eigen::Vector2d& p2,
                              const Eigen::Vector2d& turn) {
  return turn.y() * (p1 + p2) / 2 + turn.x() * left_of(p2 - p1) / 2;
}

}  // namespace

std::optional<Eigen::Vector2d> intersect_sight_circles(const std::array<Eigen::Vector2d, 3>& p,
                                                       const Eigen::Vector2d& turn12,
                                                       const Eigen::Vector2d& turn23) noexcept {
  const double scale_squared = (p[0] - p[1]).squaredNorm() + (p[1] - p[2]).squaredNorm();
  // Relative to the middle point, so that coordinates have the size of the triangle.
  const Eigen::Vector2d c1 = scaled_centre(p[0] - p[1], Eigen::Vector2d::Zero(), turn12);
  const Eigen::Vector2d c2 = scaled_centre(Eigen::Vector2d::Zero(), p[2] - p[1], turn23);
  // Both circles pass through the middle point. Their other intersection is its mirror image at the line of
  // their centres.
  const double s1 = turn12.y(), s2 = turn23.y();
  const Eigen::Vector2d line = c2 * s1 - c1 * s2;
  const double tiny_squared = square(kTiny) * scale_squared;
  if (!(line.squaredNorm() > tiny_squared)) return std::nullopt;  // also rejects NaN
  const bool first = std::abs(s1) > std::abs(s2);
  const double sine = first ? s1 : s2;
  if (!(std::abs(sine) > kTiny)) return std::nullopt;
  const Eigen::Vector2d normal = left_of(line);
  const Eigen::Vector2d found = 2 * normal.dot(first ? c1 : c2) / (sine * line.squaredNorm()) * normal;
  if (!(found.squaredNorm() > tiny_squared))
    return std::nullopt;  // at the middle point itself bearings are undefined
  return p[1] + found;
}

std::optional<ResectedPose> resect(const std::array<Eigen::Vector2d, 3>& p,
                                   const std::array<Eigen::Vector2d, 3>& sight) noexcept {
  const auto found =
      intersect_sight_circles(p, turn_between(sight[0], sight[1]), turn_between(sight[1], sight[2]));
  if (!found) return std::nullopt;
  std::array<Eigen::Vector2d, 3> heading;  // heading from each of the points, times its distance
  for (std::size_t i = 0; i < 3; ++i) heading[i] = turn_between(sight[i], p[i] - *found);
  // The circles determine angles only modulo half a turn.
  if (heading[0].dot(heading[1]) < 0 || heading[0].dot(heading[2]) < 0) return std::nullopt;
  return ResectedPose{*found, heading[0].normalized()};
}

}  // namespace octant
