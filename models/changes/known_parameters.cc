// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/known_parameters.h"

#include <algorithm>
#include <cmath>

#include "models/changes/deployment_number.h"

namespace octant {
namespace {

std::vector<ParameterId> parameters_of(const Deployment& d) {
  std::vector<ParameterId> all;
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    if (d.beacons[b].status == BeaconStatus::kUndetermined) continue;
    for (std::size_t i = 0; i < 3; ++i) all.push_back(parameters::beacon_position(b, i));
    all.push_back(parameters::beacon_delay(b));
    if (d.attenuation) all.push_back(parameters::beacon_gain(b));
  }
  for (std::size_t r = 0; r < d.receivers.size(); ++r) {
    for (std::size_t i = 0; i < 3; ++i) all.push_back(parameters::receiver_position(r, i));
    if (d.timing.delay_per.receiver) all.push_back(parameters::receiver_delay(r));
  }
  all.push_back(parameters::speed());
  if (d.attenuation)
    for (std::size_t i = 0;
         i < (d.attenuation->directional() ? kAttenuationUnknowns : kAttenuationUnknowns - 1); ++i)
      all.push_back(parameters::attenuation(i));
  if (d.timing.clock == Clock::kCycleOffset)
    for (std::size_t v = 0; v < d.vehicles.size(); ++v) all.push_back(parameters::clock_drift(v));
  return all;
}

/// A parameter as a linear combination of those in the joint covariance.
using Terms = std::vector<std::pair<ParameterId, double>>;

Terms receiver_terms(const ParameterId& p, const Deployment& d) {
  Terms terms = {{p, 1.0}};
  const std::size_t vehicle = d.receivers[p.owner].vehicle.index();
  const Eigen::Vector2d o = d.receivers[p.owner].position_m.head<2>();
  if (p.component > 1 || !(o.norm() > 0)) return terms;
  terms.emplace_back(parameters::array_radius(vehicle), o[p.component] / o.norm());
  terms.emplace_back(parameters::array_turn(vehicle), p.component == 0 ? -o.y() : o.x());
  return terms;
}

/// @param speed  the speed offset of the joint covariance that the deployment uses
Terms terms_of(const ParameterId& p, const Deployment& d, const ParameterId& speed) {
  switch (p.kind) {
    case ParameterKind::kBeaconDelay: return {{p, 1.0}, {parameters::site_delay(), 1.0}};
    case ParameterKind::kReceiverPosition: return receiver_terms(p, d);
    case ParameterKind::kSpeed: return {{speed, 1.0}};
    default: return {{p, 1.0}};
  }
}

/// With one offset for each run, the last one is the most recent and is used by the deployment.
ParameterId present_speed(const JointCovariance& joint) {
  ParameterId last = parameters::speed();
  for (const ParameterId& id : joint.parameters)
    if (id.kind == ParameterKind::kSpeed && id.owner > last.owner) last = id;
  return last;
}

/// Covariance by beacon, for sites that are too large for a joint covariance.
Eigen::MatrixXd separate_covariance(const KnownParameters& known, const Deployment& d) {
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(known.size(), known.size());
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(i)];
    if (p.kind == ParameterKind::kBeaconPosition)
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        C(i, i - p.component + axis) = d.beacons[p.owner].covariance_m2(p.component, axis);
    if (p.kind == ParameterKind::kBeaconDelay || p.kind == ParameterKind::kReceiverPosition ||
        p.kind == ParameterKind::kReceiverDelay || p.kind == ParameterKind::kSpeed)
      C(i, i) = std::pow(number_in(d, p).sigma, 2);
  }
  return C;
}

}  // namespace

KnownParameters known_parameters(const Deployment& d) {
  KnownParameters known;
  known.speed_mps = d.speed_mps(d.medium.temperature_degC);
  known.parameters = parameters_of(d);
  const auto n = static_cast<Eigen::Index>(known.parameters.size());
  known.value.resize(n);
  for (Eigen::Index i = 0; i < n; ++i)
    known.value[i] = number_in(d, known.parameters[static_cast<std::size_t>(i)]).value;
  if (d.covariance.parameters.empty()) {
    known.covariance = separate_covariance(known, d);
    return known;
  }
  const ParameterIndex column(d.covariance.parameters);
  const ParameterId speed = present_speed(d.covariance);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n, d.covariance.matrix.cols());
  for (Eigen::Index i = 0; i < n; ++i)
    for (const auto& [id, coefficient] : terms_of(known.parameters[static_cast<std::size_t>(i)], d, speed))
      if (const int at = column[id]; at >= 0) J(i, at) = coefficient;
  known.covariance = J * d.covariance.matrix * J.transpose();
  return known;
}

namespace {

/// Sigma of the drift of a parameter between visits. Visitor for visit_parameter; parameters that deployments
/// do not store (deployment_number.cc) have no prior.
struct DriftOf : HasNothing<double> {
  const Drift& drift;
  double value;
  DriftOf(const Drift& by, double now) : drift(by), value(now) {}
  [[nodiscard]] double beacon_position(std::size_t, std::size_t) const { return drift.beacon_m; }
  [[nodiscard]] double beacon_delay(std::size_t) const { return drift.delay_s; }
  [[nodiscard]] double beacon_gain(std::size_t) const { return drift.log_gain; }
  [[nodiscard]] double receiver_position(std::size_t, std::size_t) const { return drift.receiver_m; }
  [[nodiscard]] double receiver_delay(std::size_t) const { return drift.delay_s; }
  [[nodiscard]] double speed(std::size_t) const { return drift.speed_mps; }
  [[nodiscard]] double attenuation(std::size_t unknown) const {
    constexpr double kHalfPowerAngle_rad = 0.02;
    return unknown == 3 ? kHalfPowerAngle_rad : drift.attenuation * std::max(1e-9, std::abs(value));
  }
  [[nodiscard]] static double clock_drift(std::size_t) { return 1.0e-6; }
};

}  // namespace

Eigen::VectorXd drift_variances(const KnownParameters& known, const Drift& drift) {
  Eigen::VectorXd sigma(known.size());
  for (Eigen::Index i = 0; i < known.size(); ++i)
    sigma[i] = visit_parameter(known.parameters[static_cast<std::size_t>(i)], DriftOf(drift, known.value[i]));
  return sigma.cwiseAbs2();
}

Eigen::MatrixXd map_motions(const KnownParameters& known, Motion motion) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (Eigen::Index i = 0; i < known.size(); ++i)
    if (const ParameterId& p = known.parameters[static_cast<std::size_t>(i)];
        p.kind == ParameterKind::kBeaconPosition) {
      centre[p.component] += known.value[i];
      count += 1.0 / 3.0;
    }
  centre /= std::max(count, 1.0);
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(known.size(), pose_dof(motion));
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(i)];
    if (p.kind != ParameterKind::kBeaconPosition) continue;
    const Eigen::Vector3d at = known.value.segment<3>(i - p.component) - centre;
    T.row(i) = map_motions_at(at, motion).row(p.component);
  }
  return T;
}

}  // namespace octant
