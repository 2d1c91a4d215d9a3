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

/// An unknown offset of the speed of sound, common to all arrivals of a drive.
struct SpeedBelief {
  double offset_mps = 0.0;      ///< difference from the speed of the deployment
  double variance_m2ps2 = 0.0;  ///< 0: known speed
};

/// Bounded acceleration of a coasting vehicle (Singer, IEEE Trans. AES-6, 1970): after g seconds without
/// odometry each axis has changed its velocity by a sigma of a min(g, T), with a = v / T for the largest
/// velocity v and the time T in which the vehicle reaches it.
struct MotionLimits {
  double speed_mps = 1.0, speed_time_s = 1.0;
  double turn_rate_radps = 1.0, turn_time_s = 1.0;
};

/// Iterated extended Kalman filter of a drive, with 3 degrees of freedom in the plane or 6 in space. Odometry
/// moves the pose, and arrivals correct it one by one. Arrivals beyond the gate are rejected. Runs forward
/// or, with inverted steps, backward in time.
///
/// The offset of the speed of sound is a state as well, with zero variance if the speed is known. Without
/// odometry the filter coasts: the velocity becomes a state until odometry is available again. With an echo
/// share, each arrival corrects by the probability that it came directly (probabilistic data association,
/// Bar-Shalom and Tse, Automatica 11, 1975), so that an ambiguous one widens the covariance.
///
/// With a calibration, its parameters theta (covariance C) and a constant bias of each pair are considered,
/// not estimated. The filter keeps their covariance with the pose, so that errors that do not average out
/// remain in its covariance (Schmidt, Application of state-space methods to navigation problems, Advances in
/// Control Systems 3, 1966; Jazwinski 1970, section 8.4). An arrival whose error is correlated with earlier
/// ones of its pair is weighted by the information it adds (correlated_arrivals.h).
template <int kDof>
class DriveFilterOf {
 public:
  using Vector = Eigen::Matrix<double, kDof, 1>;
  using Covariance = Eigen::Matrix<double, kDof, kDof>;  ///< covariance of the pose in the tangent of Motion
  /// States: the pose's tangent, the speed's offset [m/s], and the velocity in the vehicle's frame.
  static constexpr int kSpeed = kDof, kVelocity = kDof + 1, kStates = 2 * kDof + 1;
  using State = Eigen::Matrix<double, kStates, 1>;
  using Row = Eigen::Matrix<double, 1, kStates>;
  static constexpr Motion kMotion = kDof == 3 ? Motion::kPlanar : Motion::kSpatial;

  /// @param calibration  null: calibration errors only widen the gate
  DriveFilterOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
                const CalibrationPart* calibration = nullptr);

  /// @param by  derivatives of the pose by the considered parameters; null: zero
  void start(const Pose& T_map_vehicle, const Covariance& covariance, const NodeCalibration* by = nullptr);
  /// Starts at the state of another filter, with its speed and velocity, and another covariance of the pose.
  void start_as(const DriveFilterOf& other, const Covariance& covariance);
  /// Starts with a speed that was estimated together with the pose. @param by_speed  derivative of the pose
  /// by the speed
  void set_speed(const SpeedBelief& speed, const Vector& by_speed = Vector::Zero());
  [[nodiscard]] SpeedBelief speed() const { return {speed_offset_mps_, P_(kSpeed, kSpeed)}; }
  /// Lets the speed of sound change as air does, a degree an hour.
  void drift_speed(double span_s);
  /// Adds a further possible error of the pose to the covariance.
  void widen(const Vector& off) { P_.template topLeftCorner<kDof, kDof>() += off * off.transpose(); }
  /// Odometry is missing from now on. @param velocity, variance  in the vehicle's frame, for each axis
  void begin_coasting(const Vector& velocity, const Vector& variance);
  /// Moves by the velocity. @param since_s  time since the last odometry
  void coast(double span_s, double since_s, const MotionLimits& limits);
  /// Odometry is available again and measures the velocity at the end of the gap.
  void end_coasting(const Vector& velocity, const Vector& variance);
  /// Returns true if the sigmas of position and rotation are below these limits.
  [[nodiscard]] bool is_within(double place_m, double turn_rad) const {
    constexpr int kPlaces = kDof == 3 ? 2 : 3;
    const auto variances = P_.diagonal();
    return variances.template head<kPlaces>().maxCoeff() < place_m * place_m &&
           variances.template segment<kDof - kPlaces>(kPlaces).maxCoeff() < turn_rad * turn_rad;
  }
  [[nodiscard]] bool is_coasting() const { return coasting_; }
  [[nodiscard]] const Vector& velocity() const { return velocity_; }
  [[nodiscard]] Covariance velocity_covariance() const { return P_.template bottomRightCorner<kDof, kDof>(); }
  /// Share of arrivals that are echoes; 0: every arrival within the gate is direct.
  void set_echo_share(double share) { echo_share_ = share; }
  /// Moves by a part of an odometry step: `step` is that part, `share` its share of the variance of the whole
  /// step.
  void predict(const Pose& step, const OdometryObservation& whole, double share);
  /// Corrects by an arrival at the current instant. Returns kUsed, or the reason for rejecting it.
  Rejection update(const Trajectory& trajectory, const ArrivalObservation& arrival);

  /// Returns true if an arrival is within the gate of the prediction; the state does not change.
  [[nodiscard]] bool fits(const Trajectory& trajectory, const ArrivalObservation& arrival);
  /// Continues with the state of another filter of the same model.
  void copy_state(const DriveFilterOf& other);

  [[nodiscard]] const Pose& pose() const { return T_map_vehicle_; }
  [[nodiscard]] Covariance covariance() const { return P_.template topLeftCorner<kDof, kDof>(); }
  /// Returns true if too few of the recent arrivals (exponential window of about thirty) could be used.
  [[nodiscard]] bool is_lost() const { return acceptance_ < 0.35; }
  /// Share of the recent arrivals that could be used.
  [[nodiscard]] double acceptance() const { return acceptance_; }
  void set_range_uncertainty(double range_uncertainty_m) { range_uncertainty_m_ = range_uncertainty_m; }

  /// Preallocated argument for `start`.
  [[nodiscard]] NodeCalibration node_calibration_room() const;

 private:
  struct Considered;
  [[nodiscard]] static Row row_of(const PathOutput& path);
  [[nodiscard]] Considered consider(const PathOutput& path, const ArrivalObservation& arrival);
  [[nodiscard]] double weight_variance_s2(const ArrivalObservation& arrival);
  [[nodiscard]] double single_variance_s2(const ArrivalObservation& arrival, double speed_mps) const;
  /// Returns true if an innovation is within the gate, and computes its further derivatives.
  bool within_gate(const ArrivalObservation& arrival, const PathOutput& path, double single2,
                   Considered& considered, double& innovation);
  /// Corrects the first kCount states, the ones in use. @param share  probability of a direct arrival
  template <int kCount>
  void correct(const State& gain, const Row& H, const Considered& considered, double noise2, double share,
               const State& moved);
  [[nodiscard]] double straight_share(double innovation, double variance) const;
  void move(const State& by, Pose& pose, double& speed_offset_mps) const;

  const EpochFixModel& model_;
  const CalibrationPart* calibration_;
  double gate_sigmas_, range_uncertainty_m_;
  double echo_share_ = 0.0;
  Eigen::Matrix<double, kStates, Eigen::Dynamic> cross_,
      pair_cross_;            ///< covariance of the states with theta and with the bias of each pair
  Eigen::VectorXd by_theta_;  ///< C h_theta for an arrival
  struct Recent {
    double time_s = 0.0, sum = 0.0;  ///< arrivals of a pair, weighted by the correlation time
  };
  std::vector<Recent> recent_;  ///< for each pair; empty: independent errors
  Pose T_map_vehicle_;
  double speed_offset_mps_ = 0.0;
  bool coasting_ = false;
  Vector velocity_ = Vector::Zero();
  Eigen::Matrix<double, kStates, kStates> P_ = Eigen::Matrix<double, kStates, kStates>::Zero();
  double acceptance_ = 1.0;  ///< share of the recent arrivals that were used
};

using DriveFilter = DriveFilterOf<3>;
extern template class DriveFilterOf<3>;
extern template class DriveFilterOf<6>;

}  // namespace octant
