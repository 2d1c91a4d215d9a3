// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/reflectors/resection.h"

#include <cmath>
#include <numbers>

#include "models/physics/pose.h"

namespace octant {
namespace {

constexpr double kTiny = 1e-9;  // of centres' distance against the points': danger circle

/// Centre of the circle of all points that see p1 and p2 under an angle, times that angle's sine: in this
/// form the circle may become a line.
Eigen::Vector2d scaled_centre(const Eigen::Vector2d& p1, const Eigen::Vector2d& p2, double sine,
                              double cosine) {
  const Eigen::Vector2d d = p2 - p1;
  return sine * (p1 + p2) / 2 + cosine * Eigen::Vector2d(-d.y(), d.x()) / 2;
}

}  // namespace

std::optional<Eigen::Vector2d> intersect_sight_circles(const std::array<Eigen::Vector2d, 3>& p,
                                                       double angle12_rad, double angle23_rad) noexcept {
  const double scale = (p[0] - p[1]).norm() + (p[1] - p[2]).norm();
  if (!(scale > 0) || !std::isfinite(angle12_rad) || !std::isfinite(angle23_rad)) return std::nullopt;
  // About the middle point, so that coordinates are of the triangle's size.
  const double s1 = std::sin(angle12_rad), s2 = std::sin(angle23_rad);
  const Eigen::Vector2d c1 = scaled_centre(p[0] - p[1], Eigen::Vector2d::Zero(), s1, std::cos(angle12_rad));
  const Eigen::Vector2d c2 = scaled_centre(Eigen::Vector2d::Zero(), p[2] - p[1], s2, std::cos(angle23_rad));
  // Both circles pass through the middle point; they meet again at its mirror image behind the line of their
  // centres.
  const Eigen::Vector2d line = c2 * s1 - c1 * s2;
  const double length = line.norm();
  if (!(length > kTiny * scale)) return std::nullopt;
  const Eigen::Vector2d normal(-line.y() / length, line.x() / length);
  const bool first = std::abs(s1) > std::abs(s2);
  const double sine = first ? s1 : s2;
  if (!(std::abs(sine) > kTiny)) return std::nullopt;
  const Eigen::Vector2d found = 2 * normal.dot(first ? c1 : c2) / sine * normal;
  if (!(found.norm() > kTiny * scale))
    return std::nullopt;  // on the middle point itself there are no bearings
  return p[1] + found;
}

std::optional<ResectedPose> resect(const std::array<Eigen::Vector2d, 3>& p,
                                   const std::array<double, 3>& bearing_rad) noexcept {
  const auto found =
      intersect_sight_circles(p, bearing_rad[1] - bearing_rad[0], bearing_rad[2] - bearing_rad[1]);
  if (!found) return std::nullopt;
  ResectedPose pose{*found, 0.0};
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector2d v = p[i] - pose.p_map_m;
    const double heading = wrap_angle(std::atan2(v.y(), v.x()) - bearing_rad[i]);
    if (i == 0) pose.heading_rad = heading;
    // Circles know angles up to half a turn.
    if (std::abs(wrap_angle(heading - pose.heading_rad)) > std::numbers::pi / 2) return std::nullopt;
  }
  return pose;
}

}  // namespace octant
