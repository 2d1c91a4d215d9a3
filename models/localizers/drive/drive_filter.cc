// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/drive_filter.h"

#include <algorithm>
#include <cmath>

#include "models/physics/plane.h"
#include "models/trajectory/linearise.h"

namespace octant {
namespace {

constexpr double kForget = 1.0 / 30.0;
constexpr int kIterations = 3;

/// What calibration may be off by. It widens the gate only: it does not average out, so it must not count as
/// noise.
double calibration_variance_s2(const EpochFixModel& model, BeaconId beacon, const PathOutput& path) {
  if (beacon.index() >= model.beacon_covariance.size()) return 0.0;
  Eigen::Matrix<double, 5, 1> by;
  by << path.tof_by_beacon.transpose(), 1.0, path.tof_by_speed;
  return std::max(0.0, by.dot(model.beacon_covariance[beacon.index()] * by));
}

/// How the pose behind a step follows the one before it. In space a turn dphi in the vehicle's frame moves
/// the end of the step by -R [s]x dphi, and is one of Rs' dphi in the frame behind the step.
template <int kDof>
Eigen::Matrix<double, kDof, kDof> by_step(const Pose& T, const Pose& step) {
  Eigen::Matrix<double, kDof, kDof> F = Eigen::Matrix<double, kDof, kDof>::Identity();
  if constexpr (kDof == 3) {
    F.template topRightCorner<2, 1>() =
        left_of(Eigen::Rotation2Dd(T.heading_rad()) * step.translation_m.template head<2>());
  } else {
    F.template topRightCorner<3, 3>() = -T.rotation.toRotationMatrix() * skew(step.translation_m);
    F.template bottomRightCorner<3, 3>() = step.rotation.toRotationMatrix().transpose();
  }
  return F;
}

}  // namespace

/// What an arrival's prediction follows besides the pose: by few of the parameters, and by the bias of its
/// pair.
template <int kDof>
struct DriveFilterOf<kDof>::Considered {
  bool any = false;
  Vector cross = Vector::Zero();  ///< P_x,theta h' of all that is considered
  double variance = 0.0;          ///< h C h'
  Eigen::Index pair = -1;
};

template <int kDof>
DriveFilterOf<kDof>::DriveFilterOf(const EpochFixModel& model, double gate_sigmas, double range_uncertainty_m,
                                   const CalibrationPart* calibration)
    : model_(model),
      calibration_(calibration),
      gate_sigmas_(gate_sigmas),
      range_uncertainty_m_(range_uncertainty_m) {
  const std::size_t pairs = model.state.beacon_p_map_m.size() * model.state.receiver_p_vehicle_m.size();
  if (model.correlated.sigma_s > 0) recent_.resize(pairs);
  if (calibration == nullptr) return;
  const NodeCalibration none = node_calibration_room();
  cross_ = none.by_parameter;
  pair_cross_ = none.by_pair;
  by_theta_ = Eigen::VectorXd::Zero(cross_.cols());
}

template <int kDof>
NodeCalibration DriveFilterOf<kDof>::node_calibration_room() const {
  NodeCalibration room;
  const std::size_t pairs = model_.state.beacon_p_map_m.size() * model_.state.receiver_p_vehicle_m.size();
  room.by_parameter.setZero(kDof, calibration_ ? calibration_->covariance().cols() : 0);
  room.by_pair.setZero(
      kDof, calibration_ && model_.correlated.pair_sigma_s > 0 ? static_cast<Eigen::Index>(pairs) : 0);
  return room;
}

template <int kDof>
void DriveFilterOf<kDof>::start(const Pose& T_map_vehicle, const Covariance& covariance,
                                const NodeCalibration* by) {
  T_map_vehicle_ = T_map_vehicle;
  covariance_ = covariance;
  acceptance_ = 1.0;
  std::ranges::fill(recent_, Recent{});
  cross_.setZero();
  pair_cross_.setZero();
  if (by == nullptr || calibration_ == nullptr) return;
  cross_.noalias() = by->by_parameter * calibration_->covariance();
  covariance_.noalias() += cross_ * by->by_parameter.transpose();
  pair_cross_ = model_.correlated.pair_sigma_s * model_.correlated.pair_sigma_s * by->by_pair;
  covariance_.noalias() += pair_cross_ * by->by_pair.transpose();
}

template <int kDof>
void DriveFilterOf<kDof>::predict(const Pose& step, const OdometryObservation& whole, double share) {
  const Covariance F = by_step<kDof>(T_map_vehicle_, step);
  covariance_ = F * covariance_ * F.transpose();
  for (Eigen::Index k = 0; k < cross_.cols(); ++k) cross_.col(k) = F * Vector(cross_.col(k));
  for (Eigen::Index k = 0; k < pair_cross_.cols(); ++k) pair_cross_.col(k) = F * Vector(pair_cross_.col(k));
  constexpr int kPlaces = kDof == 3 ? 2 : 3;
  covariance_.diagonal().template head<kPlaces>().array() +=
      share * whole.distance_sigma_m * whole.distance_sigma_m;  // the same in all directions
  covariance_.diagonal().template tail<kDof - kPlaces>().array() +=
      share * whole.heading_sigma_rad * whole.heading_sigma_rad;
  T_map_vehicle_ = T_map_vehicle_ * step;
}

template <int kDof>
typename DriveFilterOf<kDof>::Considered DriveFilterOf<kDof>::consider(const PathOutput& path,
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

/// Variance by which an arrival is weighed as if errors were independent: its share of a pair's correlated
/// error grows with the number of those before it that still remember it, and counts both ways: 1 + 2 sum
/// rho.
template <int kDof>
double DriveFilterOf<kDof>::weight_variance_s2(const ArrivalObservation& a) {
  if (recent_.empty()) return a.sigma_s * a.sigma_s;
  const CorrelatedNoise& noise = model_.correlated;
  Recent& pair = recent_[a.beacon.index() * model_.state.receiver_p_vehicle_m.size() + a.receiver.index()];
  const double dt_s = std::abs(a.time_s - pair.time_s);
  pair.sum *= noise.time_s > 0 ? std::exp(-dt_s / noise.time_s) : dt_s > 0 ? 0.0 : 1.0;
  const double variance = a.sigma_s * a.sigma_s + 2.0 * pair.sum * noise.sigma_s * noise.sigma_s;
  pair.sum += 1.0;
  pair.time_s = a.time_s;
  return variance;
}

/// Schmidt's update in Joseph's form, which keeps the covariance positive for any gain.
template <int kDof>
void DriveFilterOf<kDof>::correct(const Vector& gain, const Eigen::Matrix<double, 1, kDof>& H,
                                  const Considered& considered, double noise2) {
  const Covariance A = Covariance::Identity() - gain * H;
  const Covariance mixed = A * considered.cross * gain.transpose();
  covariance_ = (A * covariance_ * A.transpose() - mixed - mixed.transpose() +
                 (noise2 + considered.variance) * gain * gain.transpose())
                    .eval();
  for (Eigen::Index k = 0; k < cross_.cols(); ++k)
    cross_.col(k) = A * Vector(cross_.col(k)) - by_theta_[k] * gain;
  for (Eigen::Index k = 0; k < pair_cross_.cols(); ++k) pair_cross_.col(k) = A * Vector(pair_cross_.col(k));
  if (considered.pair >= 0)
    pair_cross_.col(considered.pair) -=
        model_.correlated.pair_sigma_s * model_.correlated.pair_sigma_s * gain;
}

template <int kDof>
double DriveFilterOf<kDof>::single_variance_s2(const ArrivalObservation& a, double speed_mps) const {
  const double uncertainty_s = range_uncertainty_m_ * a.legs() / speed_mps;
  // A pair's lasting bias is considered beside the noise where there is a calibration.
  const double pair_s = calibration_ ? model_.correlated.pair_sigma_s : 0.0;
  return a.sigma_s * a.sigma_s + uncertainty_s * uncertainty_s - pair_s * pair_s;
}

template <int kDof>
bool DriveFilterOf<kDof>::within_gate(const ArrivalObservation& a, const PathOutput& path, double single2,
                                      Considered& considered, double& innovation) {
  const Eigen::Matrix<double, 1, kDof> H = path.tof_by_pose.template head<kDof>();
  innovation = a.tof_s - path.tof_s;
  considered = consider(path, a);
  const double predicted2 = H * covariance_ * H.transpose();
  const double calibration2 = considered.any ? considered.variance + 2.0 * H.dot(considered.cross)
                                             : calibration_variance_s2(model_, a.beacon, path);
  return innovation * innovation <= gate_sigmas_ * gate_sigmas_ * (predicted2 + single2 + calibration2);
}

template <int kDof>
bool DriveFilterOf<kDof>::fits(const Trajectory& trajectory, const ArrivalObservation& a) {
  if (!model_.beacon_usable[a.beacon.index()]) return false;
  PathInput in = path_of(trajectory, a, model_.state);
  in.T_map_vehicle = &T_map_vehicle_;
  Considered considered;
  double innovation = 0.0;
  return within_gate(a, predict_arrival(in, kMotion), single_variance_s2(a, in.speed_mps), considered,
                     innovation);
}

template <int kDof>
void DriveFilterOf<kDof>::copy_state(const DriveFilterOf& other) {
  range_uncertainty_m_ = other.range_uncertainty_m_;
  cross_ = other.cross_;
  pair_cross_ = other.pair_cross_;
  recent_ = other.recent_;
  T_map_vehicle_ = other.T_map_vehicle_;
  covariance_ = other.covariance_;
  acceptance_ = other.acceptance_;
}

template <int kDof>
Rejection DriveFilterOf<kDof>::update(const Trajectory& trajectory, const ArrivalObservation& a) {
  if (!model_.beacon_usable[a.beacon.index()]) return Rejection::kBeaconUnusable;
  PathInput in = path_of(trajectory, a, model_.state);
  const double single2 = single_variance_s2(a, in.speed_mps);
  double noise2 = single2;

  // Iterated: the measurement is linearised where it puts the pose; the misfit of the prior comes along in
  // `moved`.
  Pose T = T_map_vehicle_;
  Vector moved = Vector::Zero(), gain = Vector::Zero();
  Eigen::Matrix<double, 1, kDof> H = Eigen::Matrix<double, 1, kDof>::Zero();
  Considered considered;
  for (int k = 0; k < kIterations; ++k) {
    in.T_map_vehicle = &T;
    const PathOutput out = predict_arrival(in, kMotion);
    H = out.tof_by_pose.template head<kDof>();
    double innovation = a.tof_s - out.tof_s + H.dot(moved);
    if (k == 0) {
      if (!within_gate(a, out, single2, considered, innovation)) {
        acceptance_ -= kForget * acceptance_;
        return innovation > 0 ? Rejection::kLate : Rejection::kEarly;
      }
      noise2 += weight_variance_s2(a) - a.sigma_s * a.sigma_s;
    }
    const double predicted2 = H * covariance_ * H.transpose();
    const double S = predicted2 + 2.0 * H.dot(considered.cross) + considered.variance + noise2;
    gain = (covariance_ * H.transpose() + considered.cross) / S;
    moved = gain * innovation;
    T = retract(T_map_vehicle_, moved, kMotion);
  }
  correct(gain, H, considered, noise2);
  T_map_vehicle_ = T;
  acceptance_ += kForget * (1.0 - acceptance_);
  return Rejection::kUsed;
}

template class DriveFilterOf<3>;
template class DriveFilterOf<6>;

}  // namespace octant
