// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/drive_filter.h"

#include <algorithm>
#include <functional>
#include <span>

#include "models/physics/pose_step.h"

namespace octant {
namespace {

constexpr double kForget = 1.0 / 30.0, kForgetMisfit = 1.0 / 100.0;
/// Share of the echoes that concern a ping as a whole.
constexpr double kWholePing = 0.5;
/// A hypothesis of a smaller probability changes the covariance of the pose by less than its rounding.
constexpr double kNegligible = 1e-9;

}  // namespace

template <int kDof>
DriveFilterOf<kDof>::DriveFilterOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
                                   const CalibrationPart* calibration)
    : model_(model),
      belief_(model, gate_sigmas, range_uncertainty_m, calibration),
      explanations_{{{belief_}, {belief_}, {belief_}}} {}

template <int kDof>
void DriveFilterOf<kDof>::start(const Pose& T_map_vehicle, const Covariance& covariance,
                                const NodeCalibration* by) {
  is_ping_open_ = false;
  acceptance_ = misfit_ = 1.0;
  belief_.start(T_map_vehicle, covariance, by);
  estimate();
}

template <int kDof>
void DriveFilterOf<kDof>::start_as(const DriveFilterOf& other, const Covariance& covariance) {
  start(other.T_map_vehicle_, covariance);
  set_speed(other.speed());
  if (other.is_coasting()) begin_coasting(other.velocity(), other.velocity_covariance().diagonal());
}

template <int kDof>
void DriveFilterOf<kDof>::set_speed(const SpeedBelief& speed, const Vector& by_speed) {
  belief_.set_speed(speed, by_speed);
  estimate();
}

template <int kDof>
void DriveFilterOf<kDof>::widen(const State& off) {
  belief_.widen(off);
  estimate();
}

template <int kDof>
void DriveFilterOf<kDof>::set_range_uncertainty(double range_uncertainty_m) {
  belief_.set_range_uncertainty(range_uncertainty_m);
  for (Explanation& one : explanations_) one.belief.set_range_uncertainty(range_uncertainty_m);
}

template <int kDof>
template <class Move>
void DriveFilterOf<kDof>::move_all(Move&& move) {
  move(belief_);
  if (is_ping_open_)
    for (std::size_t i = 0; i < count_; ++i) move(explanation(i).belief);
  estimate();
}

template <int kDof>
void DriveFilterOf<kDof>::pass_time(double span_s) {
  passed_s_ += span_s;
  if (is_ping_open_ && passed_s_ > kPing_s) {
    end_ping();
    estimate();
  }
  belief_.drift_speed(span_s);
}

template <int kDof>
void DriveFilterOf<kDof>::begin_coasting(const Vector& velocity, const Vector& variance) {
  move_all([&](Belief& belief) { belief.begin_coasting(velocity, variance); });
}

template <int kDof>
void DriveFilterOf<kDof>::coast(double span_s, double since_s, const MotionLimits& limits) {
  move_all([&](Belief& belief) { belief.coast(span_s, since_s, limits); });
}

template <int kDof>
void DriveFilterOf<kDof>::end_coasting(const Vector& velocity, const Vector& variance) {
  if (is_coasting()) move_all([&](Belief& belief) { belief.end_coasting(velocity, variance); });
}

template <int kDof>
void DriveFilterOf<kDof>::predict(const Pose& step, const OdometryObservation& whole, double share) {
  move_all([&](Belief& belief) { belief.predict(step, whole, share); });
}

template <int kDof>
void DriveFilterOf<kDof>::copy_state(const DriveFilterOf& other) {
  belief_.copy_state(other.belief_);
  count_ = other.is_ping_open_ ? other.count_ : 0;
  for (std::size_t i = 0; i < count_; ++i) {
    explanation(i).belief.copy_state(other.explanation(i).belief);
    explanation(i).weight = other.explanation(i).weight;
  }
  whole_weight_ = other.whole_weight_;
  echoes_weight_ = other.echoes_weight_;
  is_ping_open_ = other.is_ping_open_;
  ping_ = other.ping_;
  passed_s_ = other.passed_s_;
  T_map_vehicle_ = other.T_map_vehicle_;
  covariance_ = other.covariance_;
  acceptance_ = other.acceptance_;
  misfit_ = other.misfit_;
}

template <int kDof>
bool DriveFilterOf<kDof>::is_within(double place_m, double turn_rad) const {
  const auto variances = covariance_.diagonal();
  return variances.template head<Belief::kPlaces>().maxCoeff() < place_m * place_m &&
         variances.template tail<kDof - Belief::kPlaces>().maxCoeff() < turn_rad * turn_rad;
}

template <int kDof>
void DriveFilterOf<kDof>::begin_ping(const ArrivalObservation& a) {
  is_ping_open_ = true;
  ping_ = {a.beacon, a.time_s};
  passed_s_ = 0.0;
  count_ = 0;
  whole_weight_ = kWholePing * echo_share_;
  echoes_weight_ = 1.0 - whole_weight_;
}

/// Visits the explanations that matter with their weight and the sum of all weights up to theirs.
template <int kDof>
template <class Add>
void DriveFilterOf<kDof>::add_explanations(Add&& add) {
  double sum = whole_weight_ + echoes_weight_;
  for (std::size_t i = 0; i < count_; ++i) {
    const Explanation& one = explanation(i);
    if (one.weight < kNegligible) continue;
    sum += one.weight;
    add(one.belief, one.weight, sum);
  }
}

/// Makes the mixture of all hypotheses the belief.
template <int kDof>
void DriveFilterOf<kDof>::end_ping() {
  is_ping_open_ = false;
  add_explanations([this](const Belief& belief, double weight, double sum) {
    if (sum - weight < kNegligible) {
      belief_.copy_state(belief);
    } else {
      belief_.mix(belief, weight / sum);
    }
  });
}

/// Pose and covariance of the mixture of all hypotheses.
template <int kDof>
void DriveFilterOf<kDof>::estimate() {
  T_map_vehicle_ = belief_.pose();
  covariance_ = belief_.covariance();
  if (!is_ping_open_) return;
  add_explanations([this](const Belief& belief, double weight, double sum) {
    const double share = weight / sum;
    const Vector off = tangent_between(T_map_vehicle_, belief.pose(), kMotion);
    covariance_ = (1.0 - share) * covariance_ + share * belief.covariance() +
                  share * (1.0 - share) * off * off.transpose();
    const Vector shift = share * off;
    T_map_vehicle_ = retract(T_map_vehicle_, shift, kMotion);
  });
}

/// Adds the hypothesis that an arrival is the first direct one of its ping. Returns its weight.
template <int kDof>
double DriveFilterOf<kDof>::begin_explanation(const Trajectory& trajectory, const ArrivalObservation& a,
                                              double weight) {
  Explanation& added = explanation(count_);
  added.belief.copy_state(belief_);
  const DriveUpdate update = added.belief.update(trajectory, a, 0.0);
  added.weight = weight * update.density;
  added.misfit = update.misfit;
  if (update.rejection != Rejection::kUsed) return 0.0;
  ++count_;
  return added.weight;
}

/// Keeps the most probable explanations, and returns the sum of all weights before they are normalised.
template <int kDof>
double DriveFilterOf<kDof>::normalise() {
  std::ranges::sort(std::span(rank_).first(count_), std::ranges::greater(),
                    [this](std::size_t i) { return explanations_[i].weight; });
  double sum = whole_weight_ + echoes_weight_;
  for (std::size_t i = 0; i < count_; ++i) sum += explanation(i).weight;
  whole_weight_ /= sum;
  echoes_weight_ /= sum;
  for (std::size_t i = 0; i < count_; ++i) explanation(i).weight /= sum;
  count_ = std::min(count_, kExplanations);
  while (count_ > 0 && explanation(count_ - 1).weight < kNegligible) --count_;
  return sum;
}

/// Extends the hypotheses by an arrival.
template <int kDof>
Rejection DriveFilterOf<kDof>::explain(const Trajectory& trajectory, const ArrivalObservation& a) {
  if (!is_ping_open_ || !ping_.includes(a.beacon, a.time_s)) {
    if (is_ping_open_) end_ping();
    begin_ping(a);
  }
  const double single_share = (1.0 - kWholePing) * echo_share_,
               first_weight = (1.0 - single_share) * echoes_weight_;
  const bool is_late = belief_.is_late(trajectory, a);
  whole_weight_ *= echo_density(is_late);
  echoes_weight_ *= single_share * echo_density(is_late);
  double direct = 0.0;
  bool is_explained = false;
  for (std::size_t i = 0; i < count_; ++i) {
    const DriveUpdate update = explanation(i).belief.update(trajectory, a, single_share);
    explanation(i).weight *= update.density;
    explanation(i).misfit = update.misfit;
    if (update.rejection != Rejection::kUsed) continue;
    direct += explanation(i).weight;
    is_explained = is_explained || i == 0;
  }
  if (!is_explained) direct += begin_explanation(trajectory, a, first_weight);
  if (direct > 0.5 * normalise()) {
    misfit_ += kForgetMisfit * (explanation(0).misfit - misfit_);
    return Rejection::kUsed;
  }
  return is_late ? Rejection::kLate : Rejection::kEarly;
}

template <int kDof>
Rejection DriveFilterOf<kDof>::update(const Trajectory& trajectory, const ArrivalObservation& a) {
  if (!model_.beacon_usable[a.beacon.index()]) return Rejection::kBeaconUnusable;
  const Rejection rejection =
      echo_share_ > 0.0 ? explain(trajectory, a) : belief_.update(trajectory, a, 0.0).rejection;
  acceptance_ += kForget * ((rejection == Rejection::kUsed ? 1.0 : 0.0) - acceptance_);
  estimate();
  return rejection;
}

template class DriveFilterOf<3>;
template class DriveFilterOf<6>;

}  // namespace octant
