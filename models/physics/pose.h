// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "models/support/eigen_abi.h"

namespace octant {

/// Rigid motion T_a_b: p_a = rotation * p_b + translation_m. The pose of a vehicle is T_map_vehicle.
struct Pose {
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();

  /// Planar pose: z = 0, rotation about +z by heading_rad (counter-clockwise).
  [[nodiscard]] static Pose planar(double x_m, double y_m, double heading_rad);
  /// Angle of the vehicle's x axis about map +z, in (-pi, pi].
  [[nodiscard]] double heading_rad() const;
  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& p) const {
    return rotation * p + translation_m;
  }
  [[nodiscard]] Pose operator*(const Pose& other) const;
  [[nodiscard]] Pose inverse() const;
};

/// Wraps an angle into (-pi, pi].
[[nodiscard]] double wrap_angle(double angle_rad);

/// Rotation vector of a unit quaternion, |phi| <= pi, and back.
[[nodiscard]] Eigen::Vector3d log_rotation(const Eigen::Quaterniond& q);
[[nodiscard]] Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& phi);
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v);
/// Right Jacobian of SO(3) and its inverse: Exp(phi + d) ~ Exp(phi) Exp(Jr d). Accurate to about 1e-14 up to
/// half a turn; the inverse is singular only at a full turn.
[[nodiscard]] Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& phi);
[[nodiscard]] Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& phi);

/// Interpolates between a (alpha = 0) and b (alpha = 1): linear in translation, shortest rotation.
[[nodiscard]] Pose interpolate(const Pose& a, const Pose& b, double alpha);

/// Motion of a vehicle, which defines the tangent space of its pose. Planar: (x, y) in the map and heading, 3
/// values. Spatial: translation in the map and rotation in the vehicle frame, 6 values.
enum class Motion { kPlanar, kSpatial };
[[nodiscard]] constexpr int pose_dof(Motion motion) { return motion == Motion::kPlanar ? 3 : 6; }
/// Index of the first rotational degree of freedom of a pose.
[[nodiscard]] constexpr int first_turn(Motion motion) { return motion == Motion::kPlanar ? 2 : 3; }

/// Information of an unknown angle, which lies somewhere on the circle.
inline constexpr double kVagueAngle = 1.0 / (std::numbers::pi * std::numbers::pi);

/// Adds this information to the rotations of a block whose first unknowns are those of a pose.
template <class Block>
void add_vague_angles(Motion motion, Block& information) {
  for (int i = first_turn(motion); i < pose_dof(motion); ++i) information(i, i) += kVagueAngle;
}

/// Motion of a map point with the whole map, by column: translation along x, y and rotation about z (planar),
/// or along and about all three axes. Rotations are about the origin [m, m/rad].
[[nodiscard]] Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 6> map_motions_at(
    const Eigen::Vector3d& p_map_m, Motion motion);

/// Tangent vector of a pose (see Motion).
using PoseTangent = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1>;

/// Tangent vector from one pose to another: retract(from, tangent_between(from, to, motion), motion) equals
/// `to`. For planar motion this is limited to the planar components of `to`.
[[nodiscard]] PoseTangent tangent_between(const Pose& from, const Pose& to, Motion motion);

/// Moves a pose by a tangent vector (see Motion).
[[nodiscard]] Pose retract(const Pose& pose, const Eigen::Ref<const Eigen::VectorXd>& delta, Motion motion);

}  // namespace octant
