// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "models/localizers/epoch_fix.h"

namespace octant {

/// Iterated extended Kalman filter of a planar drive: odometry moves the pose, arrivals correct it one by one; those beyond
/// the gate are left out. Runs forward or, with the steps inverted, backward in time.
class DriveFilter {
 public:
  DriveFilter(const EpochFixModel& model, double gate_sigmas, double range_slack_m)
      : model_(model), gate_sigmas_(gate_sigmas), range_slack_m_(range_slack_m) {}

  void start(const Pose& T_map_vehicle, const Eigen::Matrix3d& covariance);
  /// Moves on by a part of an odometry step: `step` is that part, `share` its share of the whole step's variance.
  void predict(const Pose& step, const OdometryObservation& whole, double share);
  /// Corrects by an arrival at the present instant. Returns whether it was used or why not.
  Rejection update(const Trajectory& trajectory, const ArrivalObservation& arrival);

  [[nodiscard]] const Pose& pose() const { return T_map_vehicle_; }
  [[nodiscard]] const Eigen::Matrix3d& covariance() const { return covariance_; }
  /// Of the recent arrivals (exponentially forgotten over some thirty) too few could be used.
  [[nodiscard]] bool is_lost() const { return acceptance_ < 0.35; }
  void set_range_slack(double range_slack_m) { range_slack_m_ = range_slack_m; }

 private:
  const EpochFixModel& model_;
  double gate_sigmas_, range_slack_m_;
  Pose T_map_vehicle_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Identity();
  double acceptance_ = 1.0;  ///< share of the recent arrivals that were used
};

}  // namespace octant
