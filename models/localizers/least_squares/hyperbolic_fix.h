// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

namespace octant {

// L. Kleeman, "Ultrasonic autonomous robot localisation system", section 4.1: a point from three distances
// with a common unknown excess. Only their differences count, and each difference is a hyperbola.
//
// Extension to space: the beacons are above the plane of the receivers by a known height h. With the
// horizontal distance r, the slant distance is d = sqrt(r^2 + h^2), and its derivative by r is cos(elevation)
// = r / d. The direction of a beacon (cos psi, sin psi) is therefore foreshortened to e = r / d (cos psi, sin
// psi), and
//   dd_i = -e_i . dP
// holds for slant distances like eq. 2 in the plane. Nothing is approximated, and slant distances are not
// converted into horizontal ones, which would require the unknown offset. For level beacons |e| = 1 and all
// equations below are those of the paper.

/// A beacon relative to the receivers' plane.
struct PlanBeacon {
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  double height_m = 0.0;  ///< above or below the receivers' plane
};

/// Slant distance [m] from a point of the receivers' plane.
[[nodiscard]] double slant_distance_m(const PlanBeacon& beacon, const Eigen::Vector2d& p_map_m);

/// e: direction to the beacon, foreshortened by the cosine of its elevation; zero right below it.
[[nodiscard]] Eigen::Vector2d foreshortened(const PlanBeacon& beacon, const Eigen::Vector2d& p_map_m);

/// Derivatives of the point by the differences of distances (eq. 4): dP = by_d12 d(d1 - d2) + by_d10 d(d1 -
/// d0).
///
/// For level beacons, with psi_i the angles from the x axis to the beacons,
///   by_d12 = -(cos, sin)((psi0 + psi1) / 2) / (2 sin((psi0 - psi2) / 2) sin((psi1 - psi2) / 2))
///   by_d10 = -(cos, sin)((psi2 + psi1) / 2) / (2 sin((psi2 - psi0) / 2) sin((psi1 - psi0) / 2))
/// The cosines are the paper's dx, the sines its dy. The paper prints d(d0 - d1) in the second term; its own
/// derivation, with 0 and 2 exchanged in eq. 3, gives d(d1 - d0), which numeric derivatives confirm.
struct HyperbolicStep {
  Eigen::Vector2d by_d12, by_d10;

  /// Derivatives of the point by the three distances, columns d0, d1, d2. Rows add up to zero, because a
  /// common offset has no effect.
  [[nodiscard]] Eigen::Matrix<double, 2, 3> by_distances() const {
    Eigen::Matrix<double, 2, 3> J;
    J << -by_d10, by_d10 + by_d12, -by_d12;
    return J;
  }
};

/// @param e  foreshortened directions to the three beacons  @return no value if the hyperbolas are parallel
[[nodiscard]] std::optional<HyperbolicStep> hyperbolic_step(const std::array<Eigen::Vector2d, 3>& e);

struct HyperbolicFixOptions {
  double tolerance_m = 1e-7;  ///< a step shorter than this is the last
  double max_step_m = 3.0;    ///< longer steps are cut: the hyperbolas are only straight nearby
  int max_iterations = 40;
};

struct HyperbolicFix {
  bool converged = false;
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  HyperbolicStep step;  ///< at p_map_m
  int iterations = 0;
};

/// Intersection of the hyperbolas of three beacons near `start`, by iterating eq. 4; a step that would make
/// the misclosure worse is halved.
/// @param distance_m  slant distances, each longer than the true one by the same unknown amount
/// @return not converged where the hyperbolas do not meet, or meet too flatly
[[nodiscard]] HyperbolicFix hyperbolic_fix(const std::array<PlanBeacon, 3>& beacons,
                                           const std::array<double, 3>& distance_m,
                                           const Eigen::Vector2d& start_map_m,
                                           const HyperbolicFixOptions& options = {});

/// Second intersection of the same two hyperbolas, if there is one. With d_i^2 = |P - b_i|^2 + h_i^2 and d_i
/// minus an offset in place of d_i, the differences of these equations are linear in P and the offset. The
/// remaining quadratic has one known root.
/// @param p_map_m  an intersection, whose distances are used, so that a common offset of measured distances
/// does not matter
/// @return no value if there is no second intersection, or if the three beacons are collinear (it is then the
/// mirror image)
[[nodiscard]] std::optional<Eigen::Vector2d> other_intersection(const std::array<PlanBeacon, 3>& beacons,
                                                                const Eigen::Vector2d& p_map_m);

/// Error analysis (section 4.2; the paper refers to its report for the expression): standard deviations of x
/// and y for distances with independent sigmas s_i. With g12, g10 the columns of eq. 4,
///   s_x^2 = g10x^2 s_0^2 + (g10x + g12x)^2 s_1^2 + g12x^2 s_2^2,   and likewise for y.
/// @return [m]; infinite if the hyperbolas are parallel
[[nodiscard]] Eigen::Vector2d hyperbolic_error_m(const std::array<PlanBeacon, 3>& beacons,
                                                 const Eigen::Vector2d& p_map_m,
                                                 const std::array<double, 3>& sigma_m);

}  // namespace octant
