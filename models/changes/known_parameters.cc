// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/known_parameters.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "models/physics/attenuation.h"

namespace octant {
namespace {

double value_of(const ParameterId& p, const Deployment& d) {
  switch (p.kind) {
    case ParameterKind::kBeaconPosition: return d.beacons[p.owner].position_m[p.component];
    case ParameterKind::kBeaconDelay: return d.beacons[p.owner].delay_s;
    case ParameterKind::kBeaconGain: return std::log(d.beacons[p.owner].gain);
    case ParameterKind::kReceiverPosition: return d.receivers[p.owner].position_m[p.component];
    case ParameterKind::kReceiverDelay: return d.receivers[p.owner].delay_s;
    case ParameterKind::kSpeed: return d.speed_offset_mps;
    case ParameterKind::kAttenuation: return attenuation_unknown(*d.attenuation, p.component);
    case ParameterKind::kClockDrift: return d.vehicles[p.owner].clock_drift;
    case ParameterKind::kArray:  // it stands on the receivers
    case ParameterKind::kSiteDelay:
    case ParameterKind::kPairBias: break;
  }
  return 0.0;
}

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

/// A parameter as a sum of those of the joint covariance.
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

/// @param speed  the offset of the joint covariance that is the deployment's
Terms terms_of(const ParameterId& p, const Deployment& d, const ParameterId& speed) {
  switch (p.kind) {
    case ParameterKind::kBeaconDelay: return {{p, 1.0}, {parameters::site_delay(), 1.0}};
    case ParameterKind::kReceiverPosition: return receiver_terms(p, d);
    case ParameterKind::kSpeed: return {{speed, 1.0}};
    default: return {{p, 1.0}};
  }
}

/// Of several runs with an offset each the last is the nearest to the present, and its offset the
/// deployment's.
ParameterId present_speed(const JointCovariance& joint) {
  ParameterId last = parameters::speed();
  for (const ParameterId& id : joint.parameters)
    if (id.kind == ParameterKind::kSpeed && id.owner > last.owner) last = id;
  return last;
}

/// Of sites so large that there is no joint covariance: each beacon's own.
Eigen::MatrixXd separate_covariance(const KnownParameters& known, const Deployment& d) {
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(known.size(), known.size());
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(i)];
    if (p.kind == ParameterKind::kBeaconPosition)
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        C(i, i - p.component + axis) = d.beacons[p.owner].covariance_m2(p.component, axis);
    if (p.kind == ParameterKind::kBeaconDelay) C(i, i) = std::pow(d.beacons[p.owner].delay_sigma_s, 2);
    if (p.kind == ParameterKind::kReceiverPosition)
      C(i, i) = std::pow(d.receivers[p.owner].sigma_m[p.component], 2);
    if (p.kind == ParameterKind::kReceiverDelay) C(i, i) = std::pow(d.receivers[p.owner].delay_sigma_s, 2);
    if (p.kind == ParameterKind::kSpeed) C(i, i) = std::pow(d.speed_sigma_mps, 2);
  }
  return C;
}

}  // namespace

int KnownParameters::index_of(const ParameterId& parameter) const {
  const auto at = std::find(parameters.begin(), parameters.end(), parameter);
  return at == parameters.end() ? -1 : static_cast<int>(at - parameters.begin());
}

KnownParameters known_parameters(const Deployment& d) {
  KnownParameters known;
  known.parameters = parameters_of(d);
  const auto n = static_cast<Eigen::Index>(known.parameters.size());
  known.value.resize(n);
  for (Eigen::Index i = 0; i < n; ++i)
    known.value[i] = value_of(known.parameters[static_cast<std::size_t>(i)], d);
  if (d.covariance.parameters.empty()) {
    known.covariance = separate_covariance(known, d);
    return known;
  }
  std::unordered_map<ParameterId, Eigen::Index, ParameterHash> column;
  for (std::size_t k = 0; k < d.covariance.parameters.size(); ++k)
    column.emplace(d.covariance.parameters[k], static_cast<Eigen::Index>(k));
  const ParameterId speed = present_speed(d.covariance);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n, d.covariance.matrix.cols());
  for (Eigen::Index i = 0; i < n; ++i)
    for (const auto& [id, coefficient] : terms_of(known.parameters[static_cast<std::size_t>(i)], d, speed))
      if (const auto at = column.find(id); at != column.end()) J(i, at->second) = coefficient;
  known.covariance = J * d.covariance.matrix * J.transpose();
  return known;
}

Eigen::VectorXd drift_variances(const KnownParameters& known, const Drift& drift) {
  constexpr double kClockDrift = 1.0e-6, kHalfPowerAngle_rad = 0.02;
  Eigen::VectorXd sigma(known.size());
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(i)];
    switch (p.kind) {
      case ParameterKind::kBeaconPosition: sigma[i] = drift.beacon_m; break;
      case ParameterKind::kBeaconDelay:
      case ParameterKind::kReceiverDelay: sigma[i] = drift.delay_s; break;
      case ParameterKind::kBeaconGain: sigma[i] = drift.log_gain; break;
      case ParameterKind::kReceiverPosition: sigma[i] = drift.receiver_m; break;
      case ParameterKind::kSpeed: sigma[i] = drift.speed_mps; break;
      case ParameterKind::kAttenuation:
        sigma[i] = p.component == 3 ? kHalfPowerAngle_rad
                                    : drift.attenuation * std::max(1e-9, std::abs(known.value[i]));
        break;
      case ParameterKind::kClockDrift: sigma[i] = kClockDrift; break;
      case ParameterKind::kArray:
      case ParameterKind::kSiteDelay:
      case ParameterKind::kPairBias: sigma[i] = 0.0; break;
    }
  }
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
  const bool planar = motion == Motion::kPlanar;
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(known.size(), planar ? 3 : 6);
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(i)];
    if (p.kind != ParameterKind::kBeaconPosition) continue;
    const Eigen::Vector3d at = known.value.segment<3>(i - p.component) - centre;
    if (planar) {
      if (p.component < 2) T(i, p.component) = 1.0;
      T(i, 2) = Eigen::Vector3d::UnitZ().cross(at)[p.component];
    } else {
      T(i, p.component) = 1.0;
      for (int k = 0; k < 3; ++k) T(i, 3 + k) = Eigen::Vector3d::Unit(k).cross(at)[p.component];
    }
  }
  return T;
}

}  // namespace octant
