// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/watch/watched_pose.h"

#include <algorithm>

#include "models/physics/pose_step.h"

namespace octant {
namespace {

/// Variance of an unknown cycle offset [m^2].
constexpr double kUnknownOffset_m2 = 1e6;

}  // namespace

WatchedPose::WatchedPose(Motion motion, bool with_speed, bool with_offset, std::size_t columns)
    : motion_(motion), dof_(pose_dof(motion)) {
  int unknowns = dof_;
  if (with_speed) speed_column_ = unknowns++;
  if (with_offset) offset_column_ = unknowns++;
  F_.setZero(kMostUnknowns, static_cast<Eigen::Index>(columns));
}

void WatchedPose::start(const Pose& T_map_vehicle, const PoseCovariance& covariance) {
  T_ = T_map_vehicle;
  const auto begin = [this](int first, int count) {
    P_.middleRows(first, count).setZero();
    P_.middleCols(first, count).setZero();
    F_.middleRows(first, count).setZero();
  };
  begin(0, dof_);
  P_.topLeftCorner(dof_, dof_) = covariance;
  if (offset_column_ < 0) return;
  begin(offset_column_, 1);
  P_(offset_column_, offset_column_) = kUnknownOffset_m2;
  offset_m_ = 0.0;
}

void WatchedPose::set_speed(double offset_mps, double variance) {
  speed_mps_ = offset_mps;
  if (speed_column_ < 0) return;
  P_.row(speed_column_).setZero();
  P_.col(speed_column_).setZero();
  P_(speed_column_, speed_column_) = variance;
  F_.row(speed_column_).setZero();
}

void WatchedPose::let_speed_drift(double variance, double most) {
  if (speed_column_ < 0) return;
  double& now = P_(speed_column_, speed_column_);
  now = std::max(now, std::min(most, now + variance));
}

void WatchedPose::move(const Pose& step, const OdometryVariance& variance) {
  Matrix by = Matrix::Identity();
  if (motion_ == Motion::kPlanar) {
    by.topLeftCorner<3, 3>() = by_step<3>(T_, step);
  } else {
    by.topLeftCorner<6, 6>() = by_step<6>(T_, step);
  }
  P_ = by * P_ * by.transpose();
  for (Eigen::Index k = 0; k < F_.cols(); ++k) F_.col(k) = by * Vector(F_.col(k));
  const int shifts = first_turn(motion_);
  P_.diagonal().head(shifts).array() += variance.distance_m2;
  P_.diagonal().segment(shifts, dof_ - shifts).array() += variance.heading_rad2;
  T_ = T_ * step;
}

void WatchedPose::correct(const Vector& by_unknowns, const Eigen::VectorXd& by_change, double innovation,
                          double variance) {
  const Vector cross = P_ * by_unknowns, gain = cross / variance;
  shift(gain * innovation);
  P_.noalias() -= gain * cross.transpose();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  F_.noalias() += gain * by_change.transpose();
}

void WatchedPose::remove_change(Eigen::Index first_column, const Eigen::Vector4d& size) {
  shift(-F_.middleCols<4>(first_column) * size);
  forget_change(first_column);
}

void WatchedPose::shift(const Vector& by) {
  T_ = retract(T_, by.head(dof_), motion_);
  if (speed_column_ >= 0) speed_mps_ += by[speed_column_];
  if (offset_column_ >= 0) offset_m_ += by[offset_column_];
}

}  // namespace octant
