// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/calibration_map.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Geometry>

#include "models/support/decompositions.h"
#include "models/support/observed.h"

namespace octant::survey {
namespace {

/// The joint covariance, or its replacement.
JointCovariance joint_of(const Deployment& d) {
  if (d.covariance.matrix.rows() > 0) return d.covariance;
  JointCovariance joint;
  const auto n = static_cast<Eigen::Index>(4 * d.beacons.size() + 1);
  joint.matrix = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    for (std::size_t i = 0; i < 3; ++i) joint.parameters.push_back(parameters::beacon_position(b, i));
    joint.parameters.push_back(parameters::beacon_delay(b));
    const auto at = static_cast<Eigen::Index>(4 * b);
    joint.matrix.block<3, 3>(at, at) = d.beacons[b].covariance_m2;
    joint.matrix(at + 3, at + 3) = d.beacons[b].delay_sigma_s * d.beacons[b].delay_sigma_s;
  }
  joint.parameters.push_back(parameters::speed());
  joint.matrix(n - 1, n - 1) = d.speed_sigma_mps * d.speed_sigma_mps;
  return joint;
}

}  // namespace

CalibrationMap::CalibrationMap(const Deployment& d, const SurveyModel& model) {
  const JointCovariance joint = joint_of(d);
  if (joint.matrix.isZero(0.0)) return;
  root_ = covariance_root(joint.matrix);
  const ParameterIndex column(joint.parameters);
  // The model's beacons and receivers are some of the deployment's, or those of a scene, which are exact.
  constexpr std::array<int, 4> kExact = {-1, -1, -1, -1};
  for (const SurveyBeacon& beacon : model.beacons) {
    const auto at = std::ranges::find(d.beacons, beacon.name, &DeploymentBeacon::name);
    const auto b = static_cast<std::size_t>(at - d.beacons.begin());
    beacon_.push_back(at == d.beacons.end() ? kExact : column.beacon(b));
  }
  for (const SurveyReceiver& receiver : model.receivers) {
    const auto at = std::ranges::find_if(d.receivers, [&](const DeploymentReceiver& r) {
      return r.vehicle.index() == model.vehicle && r.name == receiver.name;
    });
    const auto r = static_cast<std::size_t>(at - d.receivers.begin());
    receiver_.push_back(at == d.receivers.end() ? kExact : column.receiver(r));
  }
  site_delay_ = column[parameters::site_delay()];
  speed_ = column[parameters::speed()];
  for (std::size_t i = 0; i < attenuation_.size(); ++i) attenuation_[i] = column[parameters::attenuation(i)];
  walk_ = d.attenuation;
  speed_mps_ = model.speed_mps;
  mps_by_delay_ = model.speed_mps / (d.timing.ranging == Ranging::kTwoWay ? 2.0 : 1.0);
}

void CalibrationMap::couple(const SurveyModel& model, const std::vector<HeardPath>& paths, double* x_row,
                            double* y_row, Eigen::Index stride) const {
  const int n = model.unknowns.count();
  UnknownsMatrix A = UnknownsMatrix::Zero(n, n);
  for (const HeardPath& p : paths) A.noalias() += p.weight * p.row * p.row.transpose();
  if (paths.empty()) return;
  const ObservedState<UnknownsMatrix> pose(A);
  if (!pose.all()) return;
  for (const HeardPath& p : paths) {
    const UnknownsVector moved = p.weight * pose.solve(p.row);
    const auto add = [&](int at, double by) {
      if (at >= 0) x_row[at * stride] += moved[0] * by, y_row[at * stride] += moved[1] * by;
    };
    const Eigen::Vector3d in_vehicle = Eigen::AngleAxisd(-p.heading_rad, Eigen::Vector3d::UnitZ()) * p.unit;
    for (int i = 0; i < 3; ++i) {
      add(beacon_[p.beacon][static_cast<std::size_t>(i)], -p.unit[i]);
      add(receiver_[p.receiver][static_cast<std::size_t>(i)], in_vehicle[i]);
    }
    for (const int delay : {beacon_[p.beacon][3], receiver_[p.receiver][3], site_delay_})
      add(delay, mps_by_delay_);
    add(speed_, -p.distance_m / speed_mps_);
    if (!walk_ || !(walk_->rise_time_s > 0)) continue;
    const Eigen::Vector3d& axis = model.receivers[p.receiver].axis;
    LogDirectivity gain;
    if (walk_->directional() && !axis.isZero())
      gain = log_directivity(-axis.dot(in_vehicle), walk_->half_power_angle_rad);
    const double below = std::min(
                     walk_->threshold_v / (amplitude_v(p.distance_m, *walk_) * std::exp(gain.value)), 0.99),
                 by_part = walk_->rise_time_s * below / (1 - below);
    add(attenuation_[0], -mps_by_delay_ * by_part / walk_->amplitude_1m_v);
    add(attenuation_[1], mps_by_delay_ * by_part * p.distance_m);
    add(attenuation_[2], -mps_by_delay_ * std::log1p(-below));
    add(attenuation_[3], -mps_by_delay_ * by_part * gain.by_half_power_angle);
  }
}

void CalibrationMap::systematic(const SurveyModel& model, std::span<const std::vector<HeardPath>> paths,
                                std::span<SystematicPart> parts) const {
  std::ranges::fill(parts, SystematicPart{});
  if (exact()) return;
  const auto count = static_cast<Eigen::Index>(paths.size());
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(2 * count, root_.rows());
  for (Eigen::Index i = 0; i < count; ++i)
    couple(model, paths[static_cast<std::size_t>(i)], &S(2 * i, 0), &S(2 * i + 1, 0), S.outerStride());
  const Eigen::MatrixXd spread = S * root_;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto x = spread.row(2 * i), y = spread.row(2 * i + 1);
    parts[static_cast<std::size_t>(i)] = {x.squaredNorm(), x.dot(y), y.squaredNorm()};
  }
}

}  // namespace octant::survey
