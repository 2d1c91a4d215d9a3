// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "models/fix.h"
#include "models/physics/pose.h"
#include "models/trajectory/odometry_noise.h"

namespace octant {

/// Kalman filter of a vehicle's pose, of the speed's offset from the deployment, and of a cycle offset [m],
/// if they are unknown. The matrix F is the sensitivity of its estimate to unmodelled changes theta of
/// beacons and receivers: E[estimate] = truth + F theta (Willsky and Jones 1976).
class WatchedPose {
 public:
  static constexpr int kMostUnknowns = 8;
  using Vector = Eigen::Matrix<double, kMostUnknowns, 1>;
  using Matrix = Eigen::Matrix<double, kMostUnknowns, kMostUnknowns>;

  /// @param columns  number of elements of theta
  WatchedPose(Motion motion, bool with_speed, bool with_offset, std::size_t columns);

  /// Sets the pose, independently of all changes; a cycle offset becomes unknown. The speed is kept.
  void start(const Pose& T_map_vehicle, const PoseCovariance& covariance);
  void set_speed(double offset_mps, double variance);
  void move(const Pose& step, const OdometryVariance& variance);
  void let_speed_drift(double variance, double most);

  /// Variance of the prediction of an observation with these derivatives.
  [[nodiscard]] double variance(const Vector& by_unknowns) const { return by_unknowns.dot(P_ * by_unknowns); }
  /// Converts the derivatives of an observation by theta into those of its innovation.
  void add_estimate(const Vector& by_unknowns, Eigen::VectorXd& by_change) const {
    by_change.noalias() -= F_.transpose() * by_unknowns;
  }
  void correct(const Vector& by_unknowns, const Eigen::VectorXd& by_change, double innovation,
               double variance);
  /// Corrects the estimate for a change that was found, whose columns begin at `first_column`.
  void remove_change(Eigen::Index first_column, const Eigen::Vector4d& size);
  void forget_change(Eigen::Index first_column) { F_.middleCols<4>(first_column).setZero(); }

  [[nodiscard]] const Pose& pose() const { return T_; }
  [[nodiscard]] double speed_offset_mps() const { return speed_mps_; }
  [[nodiscard]] double offset_m() const { return offset_m_; }
  [[nodiscard]] int pose_unknowns() const { return dof_; }
  [[nodiscard]] int speed_column() const { return speed_column_; }
  [[nodiscard]] int offset_column() const { return offset_column_; }

 private:
  void shift(const Vector& by);

  Motion motion_;
  int dof_, speed_column_ = -1, offset_column_ = -1;
  Pose T_;
  double speed_mps_ = 0.0, offset_m_ = 0.0;
  Matrix P_ = Matrix::Zero();
  Eigen::Matrix<double, kMostUnknowns, Eigen::Dynamic> F_;
};

}  // namespace octant
