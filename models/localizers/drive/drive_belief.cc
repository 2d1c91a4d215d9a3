// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/drive_belief.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/physics/pose_step.h"
#include "models/trajectory/linearise.h"

namespace octant {
namespace {

constexpr int kIterations = 3;
/// Echoes of a hall come within some three milliseconds of the direct sound, a metre of detour. Arrivals that
/// are early are rarer by a factor of ten.
constexpr double kEchoSpan_s = 3e-3, kEarlyShare = 0.1;
constexpr double kAirDrift_m2ps2_per_s = 1e-4;  ///< random walk of 0.6 m/s (a degree) in an hour

/// Calibration variance. It widens the gate only: it does not average out, so it must not count as noise.
double calibration_variance_s2(const EpochFixModel& model, BeaconId beacon, const PathOutput& path) {
  if (beacon.index() >= model.beacon_covariance.size()) return 0.0;
  Eigen::Matrix<double, 5, 1> by;
  by << path.tof_by_beacon.transpose(), 1.0, path.tof_by_speed;
  return std::max(0.0, by.dot(model.beacon_covariance[beacon.index()] * by));
}

double normal_density(double innovation, double variance) {
  return std::exp(-0.5 * innovation * innovation / variance) / std::sqrt(2.0 * std::numbers::pi * variance);
}

Rejection rejection_of(double innovation) { return innovation > 0 ? Rejection::kLate : Rejection::kEarly; }

}  // namespace

double echo_density(bool is_late) { return (is_late ? 1.0 : kEarlyShare) / kEchoSpan_s; }

/// Derivatives of an arrival's prediction besides the pose: by few of the parameters, and by the bias of its
/// pair.
template <int kDof>
struct DriveBeliefOf<kDof>::Considered {
  bool any = false;
  State cross = State::Zero();  ///< P_x,theta h' for all considered parameters
  double variance = 0.0;        ///< h C h'
  Eigen::Index pair = -1;
};

template <int kDof>
DriveBeliefOf<kDof>::DriveBeliefOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
                                   const CalibrationPart* calibration)
    : model_(model),
      calibration_(calibration),
      gate_sigmas_(gate_sigmas),
      range_uncertainty_m_(range_uncertainty_m) {
  if (model.correlated.sigma_s > 0)
    recent_ = RecentPairs(model.state.beacon_p_map_m.size(), model.state.receiver_p_vehicle_m.size());
  if (calibration == nullptr) return;
  const NodeCalibration none = node_calibration_room();
  cross_.setZero(kStates, none.by_parameter.cols());
  pair_cross_.setZero(kStates, none.by_pair.cols());
  by_theta_ = Eigen::VectorXd::Zero(cross_.cols());
}

template <int kDof>
NodeCalibration DriveBeliefOf<kDof>::node_calibration_room() const {
  NodeCalibration room;
  const std::size_t pairs = model_.state.beacon_p_map_m.size() * model_.state.receiver_p_vehicle_m.size();
  room.by_parameter.setZero(kDof, calibration_ ? calibration_->covariance().cols() : 0);
  room.by_pair.setZero(
      kDof, calibration_ && model_.correlated.pair_sigma_s > 0 ? static_cast<Eigen::Index>(pairs) : 0);
  return room;
}

template <int kDof>
void DriveBeliefOf<kDof>::start(const Pose& T_map_vehicle, const Covariance& covariance,
                                const NodeCalibration* by) {
  T_map_vehicle_ = T_map_vehicle;
  P_.setZero();
  P_.template topLeftCorner<kDof, kDof>() = covariance;
  speed_offset_mps_ = 0.0;
  coasting_ = false;
  recent_.clear();
  cross_.setZero();
  pair_cross_.setZero();
  if (by == nullptr || calibration_ == nullptr) return;
  auto P = P_.template topLeftCorner<kDof, kDof>();
  cross_.template topRows<kDof>().noalias() = by->by_parameter * calibration_->covariance();
  P.noalias() += cross_.template topRows<kDof>() * by->by_parameter.transpose();
  pair_cross_.template topRows<kDof>() =
      model_.correlated.pair_sigma_s * model_.correlated.pair_sigma_s * by->by_pair;
  P.noalias() += pair_cross_.template topRows<kDof>() * by->by_pair.transpose();
}

template <int kDof>
void DriveBeliefOf<kDof>::set_speed(const SpeedBelief& speed, const Vector& by_speed) {
  speed_offset_mps_ = speed.offset_mps;
  P_.row(kSpeed).setZero();
  P_.col(kSpeed).setZero();
  P_(kSpeed, kSpeed) = speed.variance_m2ps2;
  P_.col(kSpeed).template head<kDof>() = speed.variance_m2ps2 * by_speed;
  P_.row(kSpeed).template head<kDof>() = speed.variance_m2ps2 * by_speed.transpose();
  P_.template topLeftCorner<kDof, kDof>() += speed.variance_m2ps2 * by_speed * by_speed.transpose();
}

template <int kDof>
void DriveBeliefOf<kDof>::drift_speed(double span_s) {
  if (P_(kSpeed, kSpeed) > 0.0) P_(kSpeed, kSpeed) += kAirDrift_m2ps2_per_s * span_s;
}

template <int kDof>
void DriveBeliefOf<kDof>::predict(const Pose& step, const OdometryObservation& whole, double share) {
  const Covariance F = by_step<kDof>(T_map_vehicle_, step);
  auto cross = P_.template topRightCorner<kDof, kDof + 1>();
  auto P = P_.template topLeftCorner<kDof, kDof>();
  P = (F * P * F.transpose()).eval();
  cross = (F * cross).eval();
  P_.template bottomLeftCorner<kDof + 1, kDof>() = cross.transpose();
  for (auto* by : {&cross_, &pair_cross_})
    for (Eigen::Index k = 0; k < by->cols(); ++k)
      by->col(k).template head<kDof>() = F * Vector(by->col(k).template head<kDof>());
  P.diagonal().template head<kPlaces>().array() +=
      share * whole.distance_sigma_m * whole.distance_sigma_m;  // equal in all directions
  P.diagonal().template tail<kDof - kPlaces>().array() +=
      share * whole.heading_sigma_rad * whole.heading_sigma_rad;
  T_map_vehicle_ = T_map_vehicle_ * step;
}

template <int kDof>
void DriveBeliefOf<kDof>::begin_coasting(const Vector& velocity, const Vector& variance) {
  coasting_ = true;
  velocity_ = velocity;
  P_.template rightCols<kDof>().setZero();
  P_.template bottomRows<kDof>().setZero();
  P_.diagonal().template tail<kDof>() = variance;
  for (auto* by : {&cross_, &pair_cross_}) by->template bottomRows<kDof>().setZero();
}

template <int kDof>
void DriveBeliefOf<kDof>::coast(double span_s, double since_s, const MotionLimits& limits) {
  const Pose step = step_at(velocity_, span_s);
  Eigen::Matrix<double, kStates, kStates> F = Eigen::Matrix<double, kStates, kStates>::Identity();
  F.template topLeftCorner<kDof, kDof>() = by_step<kDof>(T_map_vehicle_, step);
  const Eigen::Matrix3d R = span_s * T_map_vehicle_.rotation.toRotationMatrix();
  F.template block<kPlaces, kPlaces>(0, kVelocity) = R.template topLeftCorner<kPlaces, kPlaces>();
  F.template block<kDof - kPlaces, kDof - kPlaces>(kPlaces, kVelocity + kPlaces)
      .diagonal()
      .setConstant(span_s);
  Vector noise2;
  for (int i = 0; i < kDof; ++i) {
    const double T = i < kPlaces ? limits.speed_time_s : limits.turn_time_s;
    const double change = (i < kPlaces ? limits.speed_mps : limits.turn_rate_radps) / T;
    const double for_s = std::min(since_s + 0.5 * span_s, T);
    // Velocity fades so that its variance ends at the square of the limit.
    F(kVelocity + i, kVelocity + i) = std::exp(-span_s * for_s / (T * T));
    noise2[i] = 2.0 * change * change * for_s * span_s;
  }
  P_ = (F * P_ * F.transpose()).eval();
  P_.diagonal().template tail<kDof>() += noise2;
  P_.diagonal().template head<kDof>() += span_s * span_s / 3.0 * noise2;
  for (auto* by : {&cross_, &pair_cross_})
    for (Eigen::Index k = 0; k < by->cols(); ++k) by->col(k) = F * State(by->col(k));
  velocity_ = F.diagonal().template tail<kDof>().cwiseProduct(velocity_);
  T_map_vehicle_ = T_map_vehicle_ * step;
}

template <int kDof>
void DriveBeliefOf<kDof>::end_coasting(const Vector& velocity, const Vector& variance) {
  if (!coasting_) return;
  for (int i = 0; i < kDof; ++i) {
    const int at = kVelocity + i;
    const State gain = P_.col(at) / (P_(at, at) + variance[i]);
    const double innovation = velocity[i] - velocity_[i];
    for (auto* by : {&cross_, &pair_cross_})
      for (Eigen::Index k = 0; k < by->cols(); ++k) by->col(k) -= gain * (*by)(at, k);
    P_ -= (gain * P_.row(at)).eval();
    P_ = (0.5 * (P_ + P_.transpose())).eval();
    const State moved = gain * innovation;
    velocity_ += moved.template tail<kDof>();
    move(moved, T_map_vehicle_, speed_offset_mps_);
  }
  begin_coasting(velocity_, Vector::Zero());
  coasting_ = false;
}

template <int kDof>
void DriveBeliefOf<kDof>::move(const State& by, Pose& pose, double& speed_offset_mps) const {
  pose = retract(pose, by.template head<kDof>(), kMotion);
  speed_offset_mps += by[kSpeed];
}

template <int kDof>
typename DriveBeliefOf<kDof>::Considered DriveBeliefOf<kDof>::consider(const PathOutput& path,
                                                                       const ArrivalObservation& a) {
  Considered out;
  out.any = calibration_ != nullptr;
  if (!out.any) return out;
  if (cross_.cols() > 0) {
    ObservationRow row;
    row.has_shared = true;
    row.beacon = a.beacon;
    row.receiver = a.receiver;
    row.by_beacon = path.tof_by_beacon;
    row.by_receiver = path.tof_by_receiver;
    row.by_attenuation = path.tof_by_attenuation;
    row.by(kByDelay) = 1.0;
    row.by(kBySpeed) = path.tof_by_speed;
    by_theta_.setZero();
    calibration_->for_each_coupling(
        row, [&](int at, double h) { by_theta_ += h * calibration_->covariance().col(at); });
    calibration_->for_each_coupling(row, [&](int at, double h) {
      out.cross += h * cross_.col(at);
      out.variance += h * by_theta_[at];
    });
  }
  if (pair_cross_.cols() > 0) {
    out.pair = static_cast<Eigen::Index>(a.beacon.index() * model_.state.receiver_p_vehicle_m.size() +
                                         a.receiver.index());
    out.cross += pair_cross_.col(out.pair);
    out.variance += model_.correlated.pair_sigma_s * model_.correlated.pair_sigma_s;
  }
  return out;
}

/// Schmidt's update in Joseph's form, which keeps the covariance positive for any gain; with a share below
/// one, the covariance of the mixture of both hypotheses.
template <int kDof>
template <int kCount>
void DriveBeliefOf<kDof>::correct(const State& whole_gain, const Row& whole_H, const Considered& considered,
                                  double noise2, double share, const State& moved) {
  using Block = Eigen::Matrix<double, kCount, kCount>;
  const Eigen::Matrix<double, kCount, 1> gain = whole_gain.template head<kCount>(),
                                         m = moved.template head<kCount>();
  const Eigen::Matrix<double, 1, kCount> H = whole_H.template head<kCount>();
  auto P = P_.template topLeftCorner<kCount, kCount>();
  const Block A = Block::Identity() - gain * H;
  const Block mixed = A * considered.cross.template head<kCount>() * gain.transpose();
  const Block corrected = A * P * A.transpose() - mixed - mixed.transpose() +
                          (noise2 + considered.variance) * gain * gain.transpose();
  P = (share * corrected + (1.0 - share) * P + share * (1.0 - share) * m * m.transpose()).eval();
  for (Eigen::Index k = 0; k < cross_.cols(); ++k) {
    auto column = cross_.col(k).template head<kCount>();
    column -= share * (H.dot(column) + by_theta_[k]) * gain;
  }
  for (Eigen::Index k = 0; k < pair_cross_.cols(); ++k) {
    auto column = pair_cross_.col(k).template head<kCount>();
    column -= share * H.dot(column) * gain;
  }
  if (considered.pair >= 0)
    pair_cross_.col(considered.pair).template head<kCount>() -=
        share * model_.correlated.pair_sigma_s * model_.correlated.pair_sigma_s * gain;
}

/// Mean square of the second-order term of an arrival's time, which a linearised update neglects (Athans,
/// Wishner and Bertolini, IEEE Trans. Automatic Control 13, 1968). It counts as noise, so that an uncertain
/// pose does not become too certain by a curved range.
template <int kDof>
double DriveBeliefOf<kDof>::curvature_variance_s2(const ArrivalObservation& a, const PathOutput& path) const {
  using Places = Eigen::Matrix<double, kPlaces, kPlaces>;
  const double slope = path.tof_by_beacon.norm();
  const Eigen::Matrix<double, kPlaces, 1> along =
      path.tof_by_pose.template head<kPlaces>().transpose() / slope;
  const Places across = (Places::Identity() - along * along.transpose()) *
                        P_.template topLeftCorner<kPlaces, kPlaces>() / std::max(path.distance_m, 1e-6);
  const double turned = model_.state.receiver_p_vehicle_m[a.receiver.index()].norm() *
                        P_.diagonal().template segment<kDof - kPlaces>(kPlaces).sum();
  return 0.25 * slope * slope *
         (across.trace() * across.trace() + 2.0 * (across * across).trace() + 3.0 * turned * turned);
}

/// Variance of an arrival's time by itself, without the prediction's.
template <int kDof>
double DriveBeliefOf<kDof>::single_variance_s2(const ArrivalObservation& a, const PathOutput& path,
                                               double speed_mps) const {
  const double uncertainty_s = range_uncertainty_m_ * a.legs() / speed_mps;
  // With a calibration, the constant bias of a pair is considered in addition to the noise.
  const double pair_s = calibration_ ? model_.correlated.pair_sigma_s : 0.0;
  return a.sigma_s * a.sigma_s + uncertainty_s * uncertainty_s - pair_s * pair_s +
         curvature_variance_s2(a, path);
}

template <int kDof>
bool DriveBeliefOf<kDof>::within_gate(const ArrivalObservation& a, const PathOutput& path, double single2,
                                      Considered& considered, double& innovation) {
  const Row H = row_of(path);
  innovation = a.tof_s - path.tof_s;
  considered = consider(path, a);
  const double predicted2 = H * P_ * H.transpose();
  const double calibration2 = considered.any ? considered.variance + 2.0 * H.dot(considered.cross)
                                             : calibration_variance_s2(model_, a.beacon, path);
  return innovation * innovation <= gate_sigmas_ * gate_sigmas_ * (predicted2 + single2 + calibration2);
}

template <int kDof>
PathInput DriveBeliefOf<kDof>::path_input(const Trajectory& trajectory, const ArrivalObservation& a) const {
  PathInput in = path_of(trajectory, a, model_.state);
  in.T_map_vehicle = &T_map_vehicle_;
  in.speed_mps += speed_offset_mps_;
  return in;
}

template <int kDof>
bool DriveBeliefOf<kDof>::fits(const Trajectory& trajectory, const ArrivalObservation& a) {
  if (!model_.beacon_usable[a.beacon.index()]) return false;
  const PathInput in = path_input(trajectory, a);
  const PathOutput out = predict_arrival(in, kMotion);
  Considered considered;
  double innovation = 0.0;
  return within_gate(a, out, single_variance_s2(a, out, in.speed_mps), considered, innovation);
}

template <int kDof>
bool DriveBeliefOf<kDof>::is_late(const Trajectory& trajectory, const ArrivalObservation& a) const {
  return a.tof_s > predict_arrival_value(path_input(trajectory, a)).tof_s;
}

template <int kDof>
void DriveBeliefOf<kDof>::copy_state(const DriveBeliefOf& other) {
  range_uncertainty_m_ = other.range_uncertainty_m_;
  cross_ = other.cross_;
  pair_cross_ = other.pair_cross_;
  recent_ = other.recent_;
  T_map_vehicle_ = other.T_map_vehicle_;
  speed_offset_mps_ = other.speed_offset_mps_;
  coasting_ = other.coasting_;
  velocity_ = other.velocity_;
  P_ = other.P_;
}

template <int kDof>
void DriveBeliefOf<kDof>::mix(const DriveBeliefOf& other, double share) {
  const State off = difference(other);
  P_ = (1.0 - share) * P_ + share * other.P_ + share * (1.0 - share) * off * off.transpose();
  cross_ = (1.0 - share) * cross_ + share * other.cross_;
  pair_cross_ = (1.0 - share) * pair_cross_ + share * other.pair_cross_;
  velocity_ += share * off.template tail<kDof>();
  move(share * off, T_map_vehicle_, speed_offset_mps_);
}

template <int kDof>
DriveUpdate DriveBeliefOf<kDof>::update(const Trajectory& trajectory, const ArrivalObservation& a,
                                        double echo_share) {
  PathInput in = path_of(trajectory, a, model_.state);
  const double base_mps = in.speed_mps;
  double noise2 = 0.0, innovation = 0.0, first_innovation = 0.0, first_variance = 1.0;

  // Iterated: the measurement is linearised at the corrected state; `moved` contains the deviation from the
  // prior.
  Pose T = T_map_vehicle_;
  double speed_offset_mps = speed_offset_mps_;
  State moved = State::Zero(), gain = State::Zero();
  Row H = Row::Zero();
  Considered considered;
  for (int k = 0; k < kIterations; ++k) {
    in.T_map_vehicle = &T;
    in.speed_mps = base_mps + speed_offset_mps;
    const PathOutput out = predict_arrival(in, kMotion);
    H = row_of(out);
    innovation = a.tof_s - out.tof_s + H.dot(moved);
    if (k == 0) {
      const double single2 = single_variance_s2(a, out, base_mps);
      if (!within_gate(a, out, single2, considered, innovation))
        return {rejection_of(innovation), echo_share * echo_density(innovation > 0), 0.0};
      noise2 = single2 + recent_.add(a, model_.correlated);
      first_innovation = innovation;
    }
    const State PH = P_ * H.transpose();
    const double S = H.dot(PH) + 2.0 * H.dot(considered.cross) + considered.variance + noise2;
    if (k == 0) first_variance = S;
    gain = (PH + considered.cross) / S;
    moved = gain * innovation;
    T = T_map_vehicle_;
    speed_offset_mps = speed_offset_mps_;
    move(moved, T, speed_offset_mps);
  }
  const double direct = (1.0 - echo_share) * normal_density(first_innovation, first_variance),
               density = direct + echo_share * echo_density(first_innovation > 0),
               share = echo_share > 0.0 ? direct / density : 1.0;
  if (coasting_) {
    correct<kStates>(gain, H, considered, noise2, share, moved);
    velocity_ += share * moved.template tail<kDof>();
  } else {
    correct<kVelocity>(gain, H, considered, noise2, share, moved);
  }
  move(share * moved, T_map_vehicle_, speed_offset_mps_);
  return {share < 0.5 ? rejection_of(first_innovation) : Rejection::kUsed, density,
          first_innovation * first_innovation / first_variance};
}

template class DriveBeliefOf<3>;
template class DriveBeliefOf<6>;

}  // namespace octant
