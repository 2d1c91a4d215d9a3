// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

namespace octant {

/// Chang's localization on a circular-arc rail, eq. 7 to 14, in the frame of his figure 3: beacon at the
/// origin, centre O' of the arc at (0, -C), robot on the left half, moving clockwise. (Signs and the other
/// half: RailLocalizer.)
struct ArcRail {
  double radius_m = 0.0;  ///< R
  double centre_m = 0.0;  ///< C, from the beacon to O'
};

/// Robot as the beacon sees it: at (-d cos phi, d sin phi), eq. 8.
struct ArcState {
  double d_m = 0.0;
  double phi_rad = 0.0;
};

/// Angles of the triangle beacon, robot, O'.
struct ArcAngles {
  double alpha_rad = 0.0;  ///< direction of motion above the x axis, and the angle at O'
  double beta_rad = 0.0;   ///< at the robot
  double phi_rad = 0.0;    ///< at the beacon, less a right angle
};

/// Eq. 12, 13, 11. Eq. 13 is printed with beta_n on its left side; what the law of cosines gives there is the
/// angle at the beacon, phi_n + pi/2. @return nothing where no point of the arc is at that distance, or the
/// beacon stands at the centre
[[nodiscard]] std::optional<ArcAngles> arc_angles(const ArcRail& rail, double d_m);

/// Eq. 8. @return position in the frame of figure 3
[[nodiscard]] Eigen::Vector2d arc_position_m(const ArcState& state);

/// One step as published: eq. 7 and 10 at the old state, eq. 14. The speed's part T v_n of eq. 7 follows from
/// the measured d_{n+1} - d_n by the first row of eq. 10, the angle from the second. First order in the step:
/// the error is travel^2 / 2 times the arc's and the range's curvature.
/// @return nothing where the robot is nearest to the beacon or farthest (beta = 0): there d tells nothing of
/// the motion
[[nodiscard]] std::optional<ArcState> arc_step(const ArcRail& rail, const ArcState& state, double d_next_m);

}  // namespace octant
