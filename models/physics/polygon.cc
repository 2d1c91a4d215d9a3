// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/polygon.h"

#include <algorithm>
#include <cmath>

#include "models/physics/plane.h"

namespace octant {
namespace {

using Eigen::Vector2d;

double turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) { return cross(b - a, c - a); }

bool within_box(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  return (p.array() >= a.cwiseMin(b).array()).all() && (p.array() <= a.cwiseMax(b).array()).all();
}

bool meet(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const double c_side = turn(a, b, c), d_side = turn(a, b, d), a_side = turn(c, d, a), b_side = turn(c, d, b);
  if (((c_side > 0) != (d_side > 0)) && ((a_side > 0) != (b_side > 0)) && c_side != 0 && d_side != 0 &&
      a_side != 0 && b_side != 0)
    return true;
  return (c_side == 0 && within_box(a, b, c)) || (d_side == 0 && within_box(a, b, d)) ||
         (a_side == 0 && within_box(c, d, a)) || (b_side == 0 && within_box(c, d, b));
}

}  // namespace

Eigen::AlignedBox2d bounds_of(std::span<const Vector2d> points) {
  Eigen::AlignedBox2d box;
  for (const Vector2d& p : points) box.extend(p);
  return box;
}

double signed_area_m2(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return twice / 2;
}

bool is_inside(const Polygon& polygon, const Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vector2d &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

Vector2d nearest_on_outline(const Polygon& polygon, const Vector2d& p) {
  Vector2d nearest = polygon.front();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], along = polygon[(i + 1) % polygon.size()] - a;
    const double part =
        along.squaredNorm() > 0 ? std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0) : 0.0;
    if (const Vector2d q = a + part * along; (q - p).squaredNorm() < (nearest - p).squaredNorm()) nearest = q;
  }
  return nearest;
}

double distance_to_outline_m(const Polygon& polygon, const Vector2d& p) {
  return (nearest_on_outline(polygon, p) - p).norm();
}

std::optional<std::pair<std::size_t, std::size_t>> self_crossing(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const Vector2d &a = polygon[i], &b = polygon[(i + 1) % n], &c = polygon[j], &d = polygon[(j + 1) % n];
      if (j == i + 1 || (i == 0 && j == n - 1)) {
        // Neighbouring sides share a corner but must not fold back onto each other.
        const Vector2d &shared = j == i + 1 ? b : a, one = j == i + 1 ? a : b, other = j == i + 1 ? d : c;
        if (turn(shared, one, other) == 0 && (one - shared).dot(other - shared) > 0)
          return std::make_pair(i, j);
      } else if (meet(a, b, c, d)) {
        return std::make_pair(i, j);
      }
    }
  return std::nullopt;
}

Polygon convex_hull(std::vector<Vector2d> points) {
  std::ranges::sort(points, [](const Vector2d& a, const Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  if (points.size() < 3) return points;
  Polygon hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t begin = hull.size();
    for (const Vector2d& p : points) {
      while (hull.size() >= begin + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::ranges::reverse(points);
  }
  return hull;
}

}  // namespace octant
