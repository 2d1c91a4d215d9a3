// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/pose.h"

#include <cmath>

namespace octant {

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
  // Within a turn and a half the remainder is a difference without rounding (Sterbenz), and ten times as
  // fast.
  if (std::abs(angle_rad) < M_PI) return angle_rad;
  if (std::abs(angle_rad) < 3 * M_PI) {
    const double within = angle_rad - std::copysign(2 * M_PI, angle_rad);
    return within <= -M_PI ? within + 2 * M_PI : within;
  }
  const double wrapped = std::remainder(angle_rad, 2 * M_PI);
  return wrapped <= -M_PI ? wrapped + 2 * M_PI : wrapped;
}

Eigen::Vector3d log_rotation(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const double n = q.vec().norm();
  // 2 atan2(n, w) / n tends to 2 / w as n vanishes.
  const double factor = n < 1e-12 ? 2.0 : 2.0 * std::atan2(n, sign * q.w()) / n;
  return sign * factor * q.vec();
}

Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const double k = angle < 1e-8 ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  return Eigen::Quaterniond(std::cos(angle / 2), k * phi.x(), k * phi.y(), k * phi.z()).normalized();
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& phi) {
  const double a2 = phi.squaredNorm();
  const double a = std::sqrt(a2);
  const Eigen::Matrix3d K = skew(phi);
  if (a < 1e-4) return Eigen::Matrix3d::Identity() - 0.5 * K + K * K / 6;
  return Eigen::Matrix3d::Identity() - (1 - std::cos(a)) / a2 * K + (a - std::sin(a)) / (a2 * a) * K * K;
}

Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& phi) {
  const double a2 = phi.squaredNorm();
  const double a = std::sqrt(a2);
  const Eigen::Matrix3d K = skew(phi);
  if (a < 1e-4) return Eigen::Matrix3d::Identity() + 0.5 * K + K * K / 12;
  // (1 + cos a) / sin a written as 1 / tan(a/2), which keeps its digits near a half turn.
  return Eigen::Matrix3d::Identity() + 0.5 * K + (1 / a2 - 1 / (2 * a * std::tan(a / 2))) * K * K;
}

Pose interpolate(const Pose& a, const Pose& b, double alpha) {
  const Eigen::Vector3d phi = log_rotation(a.rotation.conjugate() * b.rotation);
  return {(1 - alpha) * a.translation_m + alpha * b.translation_m, a.rotation * exp_rotation(alpha * phi)};
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
