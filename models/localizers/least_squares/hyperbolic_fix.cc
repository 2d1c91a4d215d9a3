// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/hyperbolic_fix.h"

#include <cmath>
#include <limits>

#include <Eigen/LU>

namespace octant {
namespace {

constexpr double kParallel = 1e-9;  // sine between two curves below which they count as parallel
constexpr int kMaxHalvings = 12;

/// Direction in which two distances change equally: perpendicular to the difference of their directions. In
/// the plane its angle is (psi0 + psi1) / 2.
Eigen::Vector2d tangent(const Eigen::Vector2d& e_from, const Eigen::Vector2d& e_to) {
  const Eigen::Vector2d across = e_to - e_from;
  return {-across.y(), across.x()};
}

/// Differences between the measured d1 - d2 and d1 - d0 and those at a point.
Eigen::Vector2d misclosure(const std::array<PlanBeacon, 3>& b, const std::array<double, 3>& d,
                           const Eigen::Vector2d& p) {
  const double m0 = d[0] - slant_distance_m(b[0], p), m1 = d[1] - slant_distance_m(b[1], p);
  const double m2 = d[2] - slant_distance_m(b[2], p);
  return {m1 - m2, m1 - m0};
}

std::array<Eigen::Vector2d, 3> directions(const std::array<PlanBeacon, 3>& b, const Eigen::Vector2d& p) {
  return {foreshortened(b[0], p), foreshortened(b[1], p), foreshortened(b[2], p)};
}

}  // namespace

double slant_distance_m(const PlanBeacon& beacon, const Eigen::Vector2d& p_map_m) {
  return std::sqrt((beacon.p_map_m - p_map_m).squaredNorm() + beacon.height_m * beacon.height_m);
}

Eigen::Vector2d foreshortened(const PlanBeacon& beacon, const Eigen::Vector2d& p_map_m) {
  const double d_m = slant_distance_m(beacon, p_map_m);
  if (!(d_m > 0)) return Eigen::Vector2d::Zero();
  return (beacon.p_map_m - p_map_m) / d_m;
}

std::optional<HyperbolicStep> hyperbolic_step(const std::array<Eigen::Vector2d, 3>& e) {
  // Along the curve of constant d1 - d0, a step t changes d1 - d2 by -(e1 - e2) . t (eq. 2).
  const Eigen::Vector2d along_10 = tangent(e[0], e[1]), along_12 = tangent(e[2], e[1]);
  const double rate_12 = -(e[1] - e[2]).dot(along_10), rate_10 = -(e[1] - e[0]).dot(along_12);
  const double scale = along_10.norm() * along_12.norm();
  if (!(scale > 0) || !(std::abs(rate_12) > kParallel * scale)) return std::nullopt;
  return HyperbolicStep{along_10 / rate_12,
                        along_12 / rate_10};  // eq. 3, and with 0 and 2 exchanged: the terms of eq. 4
}

HyperbolicFix hyperbolic_fix(const std::array<PlanBeacon, 3>& beacons,
                             const std::array<double, 3>& distance_m, const Eigen::Vector2d& start_map_m,
                             const HyperbolicFixOptions& options) {
  HyperbolicFix fix;
  fix.p_map_m = start_map_m;
  Eigen::Vector2d open = misclosure(beacons, distance_m, fix.p_map_m);
  for (fix.iterations = 1; fix.iterations <= options.max_iterations; ++fix.iterations) {
    const auto step = hyperbolic_step(directions(beacons, fix.p_map_m));
    if (!step) return fix;
    fix.step = *step;
    Eigen::Vector2d move = step->by_d12 * open[0] + step->by_d10 * open[1];  // eq. 4
    const double length_m = move.norm();
    if (!std::isfinite(length_m)) return fix;
    if (length_m < options.tolerance_m) {
      fix.converged = true;
      return fix;
    }
    if (length_m > options.max_step_m) move *= options.max_step_m / length_m;
    for (int halving = 0;; ++halving) {
      const Eigen::Vector2d there = misclosure(beacons, distance_m, fix.p_map_m + move);
      if (there.squaredNorm() < open.squaredNorm()) {
        fix.p_map_m += move;
        open = there;
        break;
      }
      if (halving == kMaxHalvings) {  // no improvement: rounding, or no intersection
        fix.converged = length_m < 1e3 * options.tolerance_m;
        return fix;
      }
      move /= 2;
    }
  }
  return fix;
}

std::optional<Eigen::Vector2d> other_intersection(const std::array<PlanBeacon, 3>& b,
                                                  const Eigen::Vector2d& p) {
  const std::array<double, 3> d = {slant_distance_m(b[0], p), slant_distance_m(b[1], p),
                                   slant_distance_m(b[2], p)};
  // With P = p + q and distances d_i - o:  (b_i - b_0) . q = o (d_i - d_0), so q = o v, and
  //   -2 o d_0 + o^2 = |q|^2 - 2 q . (b_0 - p)  has the roots o = 0 and the other one.
  Eigen::Matrix2d B;
  B << (b[1].p_map_m - b[0].p_map_m).transpose(), (b[2].p_map_m - b[0].p_map_m).transpose();
  const double area_m2 = B.determinant();
  if (!(std::abs(area_m2) > kParallel * B.squaredNorm())) return std::nullopt;
  const Eigen::Vector2d v = B.inverse() * Eigen::Vector2d(d[1] - d[0], d[2] - d[0]);
  const double curvature = v.squaredNorm() - 1, slope_m = 2 * (v.dot(b[0].p_map_m - p) - d[0]);
  if (!(std::abs(curvature) > kParallel)) return std::nullopt;
  const double offset_m = slope_m / curvature;
  for (std::size_t i = 0; i < 3; ++i)
    if (d[i] - offset_m < std::abs(b[i].height_m))
      return std::nullopt;  // these points lie on the hyperbolas' other branches
  return Eigen::Vector2d(p + offset_m * v);
}

Eigen::Vector2d hyperbolic_error_m(const std::array<PlanBeacon, 3>& beacons, const Eigen::Vector2d& p_map_m,
                                   const std::array<double, 3>& sigma_m) {
  const auto step = hyperbolic_step(directions(beacons, p_map_m));
  if (!step) return Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  const Eigen::Matrix<double, 2, 3> J = step->by_distances();
  return (J.array().square().rowwise() *
          Eigen::Array3d(sigma_m[0], sigma_m[1], sigma_m[2]).square().transpose())
      .rowwise()
      .sum()
      .sqrt();
}

}  // namespace octant
