// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/pose.h"

#include <cmath>

namespace octant {
namespace {

/// Of turns between two rows of odometry, by which states in space are linearised millions of times: their
/// series need no trigonometry, and lose no digits to differences.
constexpr double kSmallTurn2 = 0.0625;  ///< of the angle squared; the first term left out is below 1e-16

/// Polynomial in x, lowest power first.
template <class... Rest>
double polynomial(double x, double first, Rest... rest) {
  if constexpr (sizeof...(rest) == 0) {
    return first;
  } else {
    return first + x * polynomial(x, rest...);
  }
}

/// sin(a / 2) / a and cos(a / 2), of a^2.
double half_sine_by_angle(double a2) {
  return polynomial(a2, 1.0 / 2, -1.0 / 48, 1.0 / 3840, -1.0 / 645120, 1.0 / 185794560, -1.0 / 81749606400.0);
}
double half_cosine(double a2) {
  return polynomial(a2, 1.0, -1.0 / 8, 1.0 / 384, -1.0 / 46080, 1.0 / 10321920, -1.0 / 3715891200.0);
}
/// (1 - cos a) / a^2 and (a - sin a) / a^3.
double versine_by_square(double a2) {
  return polynomial(a2, 1.0 / 2, -1.0 / 24, 1.0 / 720, -1.0 / 40320, 1.0 / 3628800, -1.0 / 479001600,
                    1.0 / 87178291200.0);
}
double sine_lag_by_cube(double a2) {
  return polynomial(a2, 1.0 / 6, -1.0 / 120, 1.0 / 5040, -1.0 / 362880, 1.0 / 39916800, -1.0 / 6227020800.0);
}
/// 1 / a^2 - 1 / (2 a tan(a / 2)).
double inverse_curvature(double a2) {
  return polynomial(a2, 1.0 / 12, 1.0 / 720, 1.0 / 30240, 1.0 / 1209600, 1.0 / 47900160,
                    691.0 / 1307674368000.0, 1.0 / 74724249600.0);
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
  if (a2 < kSmallTurn2)
    return Eigen::Matrix3d::Identity() - versine_by_square(a2) * K + sine_lag_by_cube(a2) * K * K;
  const double a = std::sqrt(a2);
  return Eigen::Matrix3d::Identity() - (1 - std::cos(a)) / a2 * K + (a - std::sin(a)) / (a2 * a) * K * K;
}

Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& phi) {
  const double a2 = phi.squaredNorm();
  const Eigen::Matrix3d K = skew(phi);
  if (a2 < kSmallTurn2) return Eigen::Matrix3d::Identity() + 0.5 * K + inverse_curvature(a2) * K * K;
  const double a = std::sqrt(a2);
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
