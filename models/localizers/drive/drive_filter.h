// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "models/localizers/drive/drive_belief.h"
#include "models/localizers/drive/ping.h"

namespace octant {

/// Sigma of a rotation beyond which a filter of a drive is not linear.
inline constexpr double kLinearTurn_rad = 0.6;

/// Filter of a drive that judges the arrivals of a ping jointly (multiple hypotheses: D. B. Reid, An
/// algorithm for tracking multiple targets, IEEE Trans. Automatic Control 24, 1979). Without an echo share it
/// is one DriveBelief, and every arrival within the gate is direct.
///
/// With an echo share, half of the echoes are those of whole pings. At the begin of a ping the state is kept.
/// The hypotheses are that all arrivals so far are echoes, which leaves that state as it was, and the two
/// most probable explanations with a direct arrival. An arrival that contradicts the best of them may be the
/// first direct one, and begins a new one. The pose is the mean of the hypotheses, with the covariance of the
/// mixture, so that an ambiguous ping is uncertain until further arrivals decide. At the end of the ping one
/// state remains.
template <int kDof>
class DriveFilterOf {
 public:
  using Belief = DriveBeliefOf<kDof>;
  using Vector = typename Belief::Vector;
  using State = typename Belief::State;
  using Covariance = typename Belief::Covariance;
  static constexpr Motion kMotion = Belief::kMotion;

  /// @param calibration  null: calibration errors only widen the gate
  DriveFilterOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
                const CalibrationPart* calibration = nullptr);

  /// @param by  derivatives of the pose by the considered parameters; null: zero
  void start(const Pose& T_map_vehicle, const Covariance& covariance, const NodeCalibration* by = nullptr);
  /// Starts with the speed and the velocity of another filter, and another covariance of its pose.
  void start_as(const DriveFilterOf& other, const Covariance& covariance);
  /// Starts with a speed that was estimated together with the pose. @param by_speed  derivative of the pose
  /// by the speed
  void set_speed(const SpeedBelief& speed, const Vector& by_speed = Vector::Zero());
  /// Difference of the state of another filter from this one.
  [[nodiscard]] State difference(const DriveFilterOf& other) const {
    return leading().difference(other.leading());
  }
  /// Adds a further possible error of the state to the covariance.
  void widen(const State& off);
  /// Share of arrivals that are echoes; 0: every arrival within the gate is direct.
  void set_echo_share(double share) { echo_share_ = share; }
  void set_range_uncertainty(double range_uncertainty_m);

  /// Time passes: the speed of sound may change as air does, and a ping ends.
  void pass_time(double span_s);
  /// Odometry is missing from now on. @param velocity, variance  in the vehicle's frame, for each axis
  void begin_coasting(const Vector& velocity, const Vector& variance);
  /// Moves by the velocity. @param since_s  time since the last odometry
  void coast(double span_s, double since_s, const MotionLimits& limits);
  /// Odometry is available again and measures the velocity at the end of the gap.
  void end_coasting(const Vector& velocity, const Vector& variance);
  /// Moves by a part of an odometry step: `step` is that part, `share` its share of the variance of the whole
  /// step.
  void predict(const Pose& step, const OdometryObservation& whole, double share);
  /// Corrects by an arrival at the current instant. Returns kUsed, or the reason for rejecting it.
  Rejection update(const Trajectory& trajectory, const ArrivalObservation& arrival);

  /// Returns true if an arrival is within the gate of the prediction; the state does not change.
  [[nodiscard]] bool fits(const Trajectory& trajectory, const ArrivalObservation& arrival) {
    return leading().fits(trajectory, arrival);
  }
  /// Continues with the state of another filter of the same model.
  void copy_state(const DriveFilterOf& other);

  [[nodiscard]] const Pose& pose() const { return T_map_vehicle_; }
  [[nodiscard]] const Covariance& covariance() const { return covariance_; }
  [[nodiscard]] SpeedBelief speed() const { return leading().speed(); }
  [[nodiscard]] bool is_coasting() const { return leading().is_coasting(); }
  [[nodiscard]] const Vector& velocity() const { return leading().velocity(); }
  [[nodiscard]] Covariance velocity_covariance() const { return leading().velocity_covariance(); }
  /// Returns true if the sigmas of position and rotation are below these limits.
  [[nodiscard]] bool is_within(double place_m, double turn_rad) const;
  /// Returns true if too few of the recent arrivals (exponential window of about thirty) could be used.
  [[nodiscard]] bool is_lost() const { return acceptance_ < 0.35; }
  /// Returns true if the open ping has a direct arrival.
  [[nodiscard]] bool is_explained() const {
    return is_ping_open_ && count_ > 0 && explanation(0).weight > 0.5;
  }
  /// Share of the recent arrivals that could be used.
  [[nodiscard]] double acceptance() const { return acceptance_; }
  /// Mean squared innovation of the recent arrivals in use, over their variance (window of about a hundred).
  [[nodiscard]] double misfit() const { return misfit_; }
  /// Preallocated argument for `start`.
  [[nodiscard]] NodeCalibration node_calibration_room() const { return belief_.node_calibration_room(); }

 private:
  static constexpr std::size_t kExplanations = 2;
  /// Explanation of a ping with a direct arrival.
  struct Explanation {
    Belief belief;
    double weight = 0.0;
    double misfit = 0.0;  ///< of the last arrival
  };
  template <class Move>
  void move_all(Move&& move);
  void begin_ping(const ArrivalObservation& arrival);
  template <class Add>
  void add_explanations(Add&& add);
  void end_ping();
  [[nodiscard]] Rejection explain(const Trajectory& trajectory, const ArrivalObservation& arrival);
  [[nodiscard]] double begin_explanation(const Trajectory& trajectory, const ArrivalObservation& arrival,
                                         double weight);
  double normalise();
  void estimate();
  /// The more probable ones first.
  [[nodiscard]] Explanation& explanation(std::size_t i) { return explanations_[rank_[i]]; }
  [[nodiscard]] const Explanation& explanation(std::size_t i) const { return explanations_[rank_[i]]; }
  [[nodiscard]] Belief& leading() { return is_explained() ? explanation(0).belief : belief_; }
  [[nodiscard]] const Belief& leading() const { return is_explained() ? explanation(0).belief : belief_; }

  const EpochFixModel& model_;
  double echo_share_ = 0.0;
  Belief belief_;                                            ///< without the arrivals of the open ping
  std::array<Explanation, kExplanations + 1> explanations_;  ///< one more for that of the last arrival
  std::array<std::size_t, kExplanations + 1> rank_{0, 1, 2};
  std::size_t count_ = 0;                            ///< of the explanations
  double whole_weight_ = 0.0, echoes_weight_ = 1.0;  ///< all are echoes: as one, and each by itself
  bool is_ping_open_ = false;
  Ping ping_;
  double passed_s_ = 0.0;  ///< since the begin of the ping
  Pose T_map_vehicle_;     ///< mean of all hypotheses
  Covariance covariance_ = Covariance::Zero();
  double acceptance_ = 1.0;  ///< share of the recent arrivals that were used
  double misfit_ = 1.0;
};

using DriveFilter = DriveFilterOf<3>;
extern template class DriveFilterOf<3>;
extern template class DriveFilterOf<6>;

}  // namespace octant
