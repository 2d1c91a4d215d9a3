// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/pose.h"

#include <cmath>

#include "models/physics/turn_series.h"

namespace octant {
namespace {

constexpr double kSmallTangent2 =
    0.0025;  ///< square of the tangent of half a turn; corresponds to kSmallTurn2

/// sin(a / 2) / a and cos(a / 2) as functions of a^2.
double half_sine_by_angle(double a2) {
  return polynomial(a2, 1.0 / 2, -1.0 / 48, 1.0 / 3840, -1.0 / 645120, 1.0 / 185794560, -1.0 / 81749606400.0);
}
double half_cosine(double a2) {
  return polynomial(a2, 1.0, -1.0 / 8, 1.0 / 384, -1.0 / 46080, 1.0 / 10321920, -1.0 / 3715891200.0);
}

}  // namespace

Pose Pose::planar(double x_m, double y_m, double heading_rad) {
  return {{x_m, y_m, 0.0}, {std::cos(heading_rad / 2), 0.0, 0.0, std::sin(heading_rad / 2)}};
}

double Pose::heading_rad() const {
  const auto& q = rotation;
  return std::atan2(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z()));
}

Pose Pose::operator*(const Pose& other) const {
  return {rotation * other.translation_m + translation_m, (rotation * other.rotation).normalized()};
}

Pose Pose::inverse() const {
  const Eigen::Quaterniond back = rotation.conjugate();
  return {-(back * translation_m), back};
}

double wrap_angle(double angle_rad) {
  // Below one and a half turns the remainder is an exact difference (Sterbenz), and ten times as fast.
  if (std::abs(angle_rad) < M_PI) return angle_rad;
  if (std::abs(angle_rad) < 3 * M_PI) {
    const double within = angle_rad - std::copysign(2 * M_PI, angle_rad);
    return within <= -M_PI ? within + 2 * M_PI : within;
  }
  const double wrapped = std::remainder(angle_rad, 2 * M_PI);
  return wrapped <= -M_PI ? wrapped + 2 * M_PI : wrapped;
}

Eigen::Vector3d log_rotation(const Eigen::Quaterniond& q) {
  const double n2 = q.vec().squaredNorm(), t2 = n2 / (q.w() * q.w());
  // 2 atan(n / w) / n; below a tenth of a radian by its series.
  if (t2 < kSmallTangent2)
    return 2.0 / q.w() * polynomial(t2, 1.0, -1.0 / 3, 1.0 / 5, -1.0 / 7, 1.0 / 9, -1.0 / 11) * q.vec();
  if (!(n2 > 0)) return Eigen::Vector3d::Zero();
  const double sign = q.w() < 0 ? -1.0 : 1.0, n = std::sqrt(n2);
  return sign * 2.0 * std::atan2(n, sign * q.w()) / n * q.vec();
}

Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& phi) {
  const double a2 = phi.squaredNorm();
  if (a2 < kSmallTurn2) {
    const double k = half_sine_by_angle(a2);
    return {half_cosine(a2), k * phi.x(), k * phi.y(), k * phi.z()};
  }
  const double angle = std::sqrt(a2), k = std::sin(angle / 2) / angle;
  return Eigen::Quaterniond(std::cos(angle / 2), k * phi.x(), k * phi.y(), k * phi.z()).normalized();
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& phi) {
  const double a2 = phi.squaredNorm();
  const Eigen::Matrix3d K = skew(phi);
  return Eigen::Matrix3d::Identity() - versine_by_square(a2) * K + sine_lag_by_cube(a2) * K * K;
}

Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& phi) {
  const Eigen::Matrix3d K = skew(phi);
  return Eigen::Matrix3d::Identity() + 0.5 * K + inverse_curvature(phi.squaredNorm()) * K * K;
}

Pose interpolate(const Pose& a, const Pose& b, double alpha) {
  const Eigen::Vector3d phi = log_rotation(a.rotation.conjugate() * b.rotation);
  return {(1 - alpha) * a.translation_m + alpha * b.translation_m, a.rotation * exp_rotation(alpha * phi)};
}

Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 6> map_motions_at(const Eigen::Vector3d& p_map_m,
                                                                               Motion motion) {
  Eigen::Matrix<double, 3, 6> all;
  all.leftCols<3>().setIdentity();
  for (int k = 0; k < 3; ++k) all.col(3 + k) = Eigen::Vector3d::Unit(k).cross(p_map_m);
  if (motion == Motion::kSpatial) return all;
  all.col(2) = all.col(5);
  return all.leftCols<3>();
}

PoseTangent tangent_between(const Pose& from, const Pose& to, Motion motion) {
  const Eigen::Vector3d off_m = to.translation_m - from.translation_m;
  PoseTangent tangent(pose_dof(motion));
  if (motion == Motion::kPlanar) {
    tangent << off_m.head<2>(), wrap_angle(to.heading_rad() - from.heading_rad());
  } else {
    tangent << off_m, log_rotation(from.rotation.conjugate() * to.rotation);
  }
  return tangent;
}

Pose retract(const Pose& pose, const Eigen::Ref<const Eigen::VectorXd>& delta, Motion motion) {
  if (motion == Motion::kPlanar) {
    return Pose::planar(pose.translation_m.x() + delta[0], pose.translation_m.y() + delta[1],
                        pose.heading_rad() + delta[2]);
  }
  return {pose.translation_m + delta.head<3>(),
          (pose.rotation * exp_rotation(delta.segment<3>(3))).normalized()};
}

}  // namespace octant
