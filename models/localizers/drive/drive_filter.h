// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/chain/chain_calibration.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/physics/measurement.h"

namespace octant {

/// Iterated extended Kalman filter of a drive, of 3 degrees of freedom in the plane or 6 in space: odometry
/// moves the pose, arrivals correct it one by one; those beyond the gate are left out. Runs forward or, with
/// the steps inverted, backward in time. With a calibration, its parameters theta (covariance C) and a
/// lasting bias of each pair are considered, not estimated: the filter carries their covariance with the
/// pose, so that what does not average out stays in what it states (Schmidt, Application of state-space
/// methods to navigation problems, Advances in Control Systems 3, 1966; Jazwinski 1970, section 8.4). An
/// arrival that shares its error with those of its pair before it is weighed by what it adds
/// (correlated_arrivals.h).
template <int kDof>
class DriveFilterOf {
 public:
  using Vector = Eigen::Matrix<double, kDof, 1>;
  using Covariance = Eigen::Matrix<double, kDof, kDof>;  ///< of the pose's tangent, as Motion has it
  static constexpr Motion kMotion = kDof == 3 ? Motion::kPlanar : Motion::kSpatial;

  /// @param calibration  null: what calibration may be off by widens the gate only
  DriveFilterOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
                const CalibrationPart* calibration = nullptr);

  /// @param by  how the pose follows an error of each considered parameter; null: not at all
  void start(const Pose& T_map_vehicle, const Covariance& covariance, const NodeCalibration* by = nullptr);
  /// Moves on by a part of an odometry step: `step` is that part, `share` its share of the whole step's
  /// variance.
  void predict(const Pose& step, const OdometryObservation& whole, double share);
  /// Corrects by an arrival at the present instant. Returns whether it was used or why not.
  Rejection update(const Trajectory& trajectory, const ArrivalObservation& arrival);

  /// Whether an arrival is within the gate of what is expected now; nothing changes.
  [[nodiscard]] bool fits(const Trajectory& trajectory, const ArrivalObservation& arrival);
  /// Goes on with what another filter of the same model holds.
  void copy_state(const DriveFilterOf& other);

  [[nodiscard]] const Pose& pose() const { return T_map_vehicle_; }
  [[nodiscard]] const Covariance& covariance() const { return covariance_; }
  /// Of the recent arrivals (exponentially forgotten over some thirty) too few could be used.
  [[nodiscard]] bool is_lost() const { return acceptance_ < 0.35; }
  void set_range_uncertainty(double range_uncertainty_m) { range_uncertainty_m_ = range_uncertainty_m; }

  /// Room for what `start` takes.
  [[nodiscard]] NodeCalibration node_calibration_room() const;

 private:
  struct Considered;
  [[nodiscard]] Considered consider(const PathOutput& path, const ArrivalObservation& arrival);
  [[nodiscard]] double weight_variance_s2(const ArrivalObservation& arrival);
  [[nodiscard]] double single_variance_s2(const ArrivalObservation& arrival, double speed_mps) const;
  /// Whether an innovation is within the gate; fills what else the prediction follows.
  bool within_gate(const ArrivalObservation& arrival, const PathOutput& path, double single2,
                   Considered& considered, double& innovation);
  void correct(const Vector& gain, const Eigen::Matrix<double, 1, kDof>& H, const Considered& considered,
               double noise2);

  const EpochFixModel& model_;
  const CalibrationPart* calibration_;
  double gate_sigmas_, range_uncertainty_m_;
  Eigen::Matrix<double, kDof, Eigen::Dynamic> cross_,
      pair_cross_;            ///< covariance of the pose with theta and with each pair's bias
  Eigen::VectorXd by_theta_;  ///< C h_theta of an arrival
  struct Recent {
    double time_s = 0.0, sum = 0.0;  ///< arrivals of a pair, each forgotten by the correlation time
  };
  std::vector<Recent> recent_;  ///< of each pair; empty: errors are independent
  Pose T_map_vehicle_;
  Covariance covariance_ = Covariance::Identity();
  double acceptance_ = 1.0;  ///< share of the recent arrivals that were used
};

using DriveFilter = DriveFilterOf<3>;
extern template class DriveFilterOf<3>;
extern template class DriveFilterOf<6>;

}  // namespace octant
