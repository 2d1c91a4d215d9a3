// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "models/localizers/chain/chain_calibration.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/drive/recent_pairs.h"
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

/// Result of an arrival. Densities are in 1/s.
struct DriveUpdate {
  Rejection rejection = Rejection::kUsed;
  double density = 0.0;  ///< of the arrival's time by the prediction, direct or an echo
  double misfit = 0.0;   ///< squared innovation over its variance
};

/// Density of an echo's time. Early arrivals are rarer than late ones.
[[nodiscard]] double echo_density(bool is_late);

/// State of a drive with its covariance, of 3 degrees of freedom in the plane or 6 in space, under one
/// explanation of the arrivals. Odometry moves the pose, and arrivals correct it one by one (iterated
/// extended Kalman filter). Arrivals beyond the gate are rejected. Runs forward or, with inverted steps,
/// backward.
///
/// The offset of the speed of sound is a state as well, with zero variance if the speed is known. Without
/// odometry the state coasts: the velocity is estimated until odometry is available again. With an echo
/// share, each arrival corrects by the probability that it came directly (probabilistic data association,
/// Bar-Shalom and Tse, Automatica 11, 1975), so that an ambiguous one widens the covariance.
///
/// With a calibration, its parameters theta (covariance C) and a constant bias of each pair are considered,
/// not estimated. Their covariance with the state is kept, so that errors that do not average out remain in
/// the covariance (Schmidt, Application of state-space methods to navigation problems, Advances in Control
/// Systems 3, 1966; Jazwinski 1970, section 8.4). An arrival whose error is correlated with earlier ones of
/// its pair is weighted by the information it adds (correlated_arrivals.h).
template <int kDof>
class DriveBeliefOf {
 public:
  using Vector = Eigen::Matrix<double, kDof, 1>;
  using Covariance = Eigen::Matrix<double, kDof, kDof>;  ///< covariance of the pose in the tangent of Motion
  /// States: the pose's tangent, the speed's offset [m/s], and the velocity in the vehicle's frame.
  static constexpr int kPlaces = kDof == 3 ? 2 : 3, kSpeed = kDof, kVelocity = kDof + 1,
                       kStates = 2 * kDof + 1;
  using State = Eigen::Matrix<double, kStates, 1>;
  using Row = Eigen::Matrix<double, 1, kStates>;
  static constexpr Motion kMotion = kDof == 3 ? Motion::kPlanar : Motion::kSpatial;

  /// @param calibration  null: calibration errors only widen the gate
  DriveBeliefOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
                const CalibrationPart* calibration = nullptr);

  /// @param by  derivatives of the pose by the considered parameters; null: zero
  void start(const Pose& T_map_vehicle, const Covariance& covariance, const NodeCalibration* by = nullptr);
  /// Starts with a speed that was estimated together with the pose. @param by_speed  derivative of the pose
  /// by the speed
  void set_speed(const SpeedBelief& speed, const Vector& by_speed = Vector::Zero());
  [[nodiscard]] SpeedBelief speed() const { return {speed_offset_mps_, P_(kSpeed, kSpeed)}; }
  /// Lets the speed of sound change as air does, a degree an hour.
  void drift_speed(double span_s);
  /// Difference of another state from this one.
  [[nodiscard]] State difference(const DriveBeliefOf& other) const {
    State off;
    off << tangent_between(T_map_vehicle_, other.T_map_vehicle_, kMotion),
        other.speed_offset_mps_ - speed_offset_mps_, other.velocity_ - velocity_;
    return off;
  }
  /// Adds a further possible error of the state to the covariance.
  void widen(const State& off) { P_ += off * off.transpose(); }
  /// Odometry is missing from now on. @param velocity, variance  in the vehicle's frame, for each axis
  void begin_coasting(const Vector& velocity, const Vector& variance);
  /// Moves by the velocity. @param since_s  time since the last odometry
  void coast(double span_s, double since_s, const MotionLimits& limits);
  /// Odometry is available again and measures the velocity at the end of the gap.
  void end_coasting(const Vector& velocity, const Vector& variance);
  [[nodiscard]] bool is_coasting() const { return coasting_; }
  [[nodiscard]] const Vector& velocity() const { return velocity_; }
  [[nodiscard]] Covariance velocity_covariance() const { return P_.template bottomRightCorner<kDof, kDof>(); }
  /// Moves by a part of an odometry step: `step` is that part, `share` its share of the variance of the whole
  /// step.
  void predict(const Pose& step, const OdometryObservation& whole, double share);
  /// Corrects by an arrival at the current instant.
  /// @param echo_share  probability of an echo; 0: every arrival within the gate is direct
  [[nodiscard]] DriveUpdate update(const Trajectory& trajectory, const ArrivalObservation& arrival,
                                   double echo_share);

  /// Returns true if an arrival is within the gate of the prediction; the state does not change.
  [[nodiscard]] bool fits(const Trajectory& trajectory, const ArrivalObservation& arrival);
  /// Returns true if an arrival is later than predicted.
  [[nodiscard]] bool is_late(const Trajectory& trajectory, const ArrivalObservation& arrival) const;
  /// Continues with another state of the same model.
  void copy_state(const DriveBeliefOf& other);
  /// Mean and covariance of the mixture with another state. @param share  probability of the other one
  void mix(const DriveBeliefOf& other, double share);

  [[nodiscard]] const Pose& pose() const { return T_map_vehicle_; }
  [[nodiscard]] Covariance covariance() const { return P_.template topLeftCorner<kDof, kDof>(); }
  void set_range_uncertainty(double range_uncertainty_m) { range_uncertainty_m_ = range_uncertainty_m; }

  /// Preallocated argument for `start`.
  [[nodiscard]] NodeCalibration node_calibration_room() const;

 private:
  struct Considered;
  [[nodiscard]] static Row row_of(const PathOutput& path) {
    Row H = Row::Zero();
    H.template head<kDof>() = path.tof_by_pose.template head<kDof>();
    H[kSpeed] = path.tof_by_speed;
    return H;
  }
  [[nodiscard]] Considered consider(const PathOutput& path, const ArrivalObservation& arrival);
  [[nodiscard]] double curvature_variance_s2(const ArrivalObservation& arrival, const PathOutput& path) const;
  [[nodiscard]] double single_variance_s2(const ArrivalObservation& arrival, const PathOutput& path,
                                          double speed_mps) const;
  /// Returns true if an innovation is within the gate, and computes its further derivatives.
  bool within_gate(const ArrivalObservation& arrival, const PathOutput& path, double single2,
                   Considered& considered, double& innovation);
  /// Corrects the first kCount states, the ones in use. @param share  probability of a direct arrival
  template <int kCount>
  void correct(const State& gain, const Row& H, const Considered& considered, double noise2, double share,
               const State& moved);
  [[nodiscard]] PathInput path_input(const Trajectory& trajectory, const ArrivalObservation& arrival) const;
  void move(const State& by, Pose& pose, double& speed_offset_mps) const;

  const EpochFixModel& model_;
  const CalibrationPart* calibration_;
  double gate_sigmas_, range_uncertainty_m_;
  Eigen::Matrix<double, kStates, Eigen::Dynamic> cross_,
      pair_cross_;            ///< covariance of the states with theta and with the bias of each pair
  Eigen::VectorXd by_theta_;  ///< C h_theta for an arrival
  RecentPairs recent_;        ///< empty: independent errors
  Pose T_map_vehicle_;
  double speed_offset_mps_ = 0.0;
  bool coasting_ = false;
  Vector velocity_ = Vector::Zero();
  Eigen::Matrix<double, kStates, kStates> P_ = Eigen::Matrix<double, kStates, kStates>::Zero();
};

extern template class DriveBeliefOf<3>;
extern template class DriveBeliefOf<6>;

}  // namespace octant
