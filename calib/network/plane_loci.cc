// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/plane_loci.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace octant::calib {
namespace {

/// More loci than this add no information on which intersection is meant.
constexpr std::size_t kMostLoci = 12;
/// Misfit relative to the size of the figure that approximate heights and slope distances may cause.
constexpr double kRelativeMisfit = 1e-3;

struct Circle {
  Eigen::Vector2d centre;
  double radius;
};

double azimuth_of(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()); }
Eigen::Vector2d unit(double azimuth) { return {std::cos(azimuth), std::sin(azimuth)}; }
double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Circle of a locus; that of an angle is the inscribed circle over the chord.
Circle circle_of(const Locus& locus) {
  if (locus.kind == Locus::kCircle) return {locus.a, locus.value};
  const Eigen::Vector2d half = 0.5 * (locus.b - locus.a);
  const Eigen::Vector2d centre =
      locus.a + half + Eigen::Vector2d(-half.y(), half.x()) / std::tan(locus.value);
  return {centre, (centre - locus.a).norm()};
}

using Points = std::vector<Eigen::Vector2d>;

Points meet(const Locus& ray, const Circle& circle) {
  const Eigen::Vector2d d = unit(ray.value), to = circle.centre - ray.a;
  const double along = to.dot(d), square = circle.radius * circle.radius - std::pow(cross(d, to), 2);
  const double half = std::sqrt(std::max(square, 0.0));
  return {ray.a + (along + half) * d, ray.a + (along - half) * d};
}

Points meet(const Circle& one, const Circle& two) {
  const Eigen::Vector2d v = two.centre - one.centre;
  const double d = v.norm();
  if (!(d > 0.0)) return {};
  const double along = 0.5 * (d + (one.radius - two.radius) * (one.radius + two.radius) / d);
  const double across = std::sqrt(std::max(one.radius * one.radius - along * along, 0.0));
  const Eigen::Vector2d e = v / d, middle = one.centre + along * e, n(-e.y(), e.x());
  return {middle + across * n, middle - across * n};
}

Points meet(const Locus& one, const Locus& two) {
  if (one.kind == Locus::kRay && two.kind == Locus::kRay) {
    const double sine = cross(unit(one.value), unit(two.value));
    if (std::abs(sine) < 1e-3) return {};
    return {one.a + cross(two.a - one.a, unit(two.value)) / sine * unit(one.value)};
  }
  if (one.kind == Locus::kRay) return meet(one, circle_of(two));
  if (two.kind == Locus::kRay) return meet(two, circle_of(one));
  return meet(circle_of(one), circle_of(two));
}

/// Distance of a point from a locus [m].
double misfit_m(const Locus& locus, const Eigen::Vector2d& p) {
  const Eigen::Vector2d v = p - locus.a;
  if (locus.kind == Locus::kCircle) return v.norm() - locus.value;
  const double angle = locus.kind == Locus::kRay ? azimuth_of(v) : azimuth_of(locus.b - p) - azimuth_of(-v);
  const double size = locus.kind == Locus::kRay ? v.norm() : std::min(v.norm(), (locus.b - p).norm());
  return size * std::remainder(angle - locus.value, 2.0 * std::numbers::pi);
}

}  // namespace

std::optional<Eigen::Vector2d> intersection(std::vector<Locus> loci) {
  if (loci.size() > kMostLoci) loci.resize(kMostLoci);
  std::vector<std::pair<double, Eigen::Vector2d>> found;
  double size_m = 0.0;
  for (const Locus& one : loci) {
    for (const Locus& two : loci) {
      if (&one >= &two) continue;
      size_m = std::max(size_m, (one.a - two.a).norm());
      for (const Eigen::Vector2d& p : meet(one, two)) {
        double sum = 0.0;
        bool distinct = p.allFinite();
        for (const Locus& locus : loci) {
          sum += std::pow(misfit_m(locus, p), 2);
          if (locus.kind != Locus::kCircle) distinct = distinct && (p - locus.a).norm() > 1e-6 * size_m;
          if (locus.kind == Locus::kAngle) distinct = distinct && (p - locus.b).norm() > 1e-6 * size_m;
          size_m = std::max(size_m, (p - locus.a).norm());
        }
        if (distinct) found.emplace_back(sum, p);
      }
    }
  }
  if (found.empty()) return std::nullopt;
  const auto best = *std::ranges::min_element(found, {}, [](const auto& f) { return f.first; });
  const double tolerance = std::pow(kRelativeMisfit * size_m, 2) * static_cast<double>(loci.size());
  if (best.first > 100.0 * tolerance) return std::nullopt;
  for (const auto& [sum, p] : found)
    if ((p - best.second).norm() > 0.05 * size_m && sum < 4.0 * best.first + tolerance) return std::nullopt;
  return best.second;
}

}  // namespace octant::calib
