// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/known_parameters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "models/physics/attenuation.h"

namespace octant {
namespace {

constexpr std::array<const char*, 3> kAxisNames = {"/x_m", "/y_m", "/z_m"};
constexpr std::array<const char*, kAttenuationUnknowns> kAttenuationNames = {
    "attenuation/amplitude_1m_v", "attenuation/absorption_np_per_m", "attenuation/rise_time_s",
    "attenuation/half_power_angle_rad"};

double attenuation_value(const AttenuationModel& a, int component) {
  const std::array<double, kAttenuationUnknowns> values = {a.amplitude_1m_v, a.absorption_np_per_m,
                                                           a.rise_time_s, a.half_power_angle_rad};
  return values[static_cast<std::size_t>(component)];
}

double value_of(const SharedParameter& p, const Deployment& d) {
  switch (p.quantity) {
    case Quantity::kBeaconPosition: return d.beacons[p.owner].position_m[p.component];
    case Quantity::kBeaconDelay: return d.beacons[p.owner].delay_s;
    case Quantity::kBeaconGain: return std::log(d.beacons[p.owner].gain);
    case Quantity::kReceiverPosition: return d.receivers[p.owner].position_m[p.component];
    case Quantity::kReceiverDelay: return d.receivers[p.owner].delay_s;
    case Quantity::kSpeed: return d.speed_offset_mps;
    case Quantity::kAttenuation: return attenuation_value(*d.attenuation, p.component);
    case Quantity::kClockDrift: return d.vehicles[p.owner].clock_drift;
  }
  return 0.0;
}

std::vector<SharedParameter> parameters_of(const Deployment& d) {
  std::vector<SharedParameter> all;
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    if (d.beacons[b].status == BeaconStatus::kUndetermined) continue;
    for (int i = 0; i < 3; ++i) all.push_back({Quantity::kBeaconPosition, b, i});
    all.push_back({Quantity::kBeaconDelay, b, 0});
    if (d.attenuation) all.push_back({Quantity::kBeaconGain, b, 0});
  }
  for (std::size_t r = 0; r < d.receivers.size(); ++r) {
    for (int i = 0; i < 3; ++i) all.push_back({Quantity::kReceiverPosition, r, i});
    if (d.timing.delay_per.receiver) all.push_back({Quantity::kReceiverDelay, r, 0});
  }
  all.push_back({Quantity::kSpeed, 0, 0});
  if (d.attenuation)
    for (int i = 0; i < (d.attenuation->directional() ? kAttenuationUnknowns : kAttenuationUnknowns - 1); ++i)
      all.push_back({Quantity::kAttenuation, 0, i});
  if (d.timing.clock == Clock::kCycleOffset)
    for (std::size_t v = 0; v < d.vehicles.size(); ++v) all.push_back({Quantity::kClockDrift, v, 0});
  return all;
}

/// A parameter as a sum of those of the joint covariance.
using Terms = std::vector<std::pair<std::string, double>>;

Terms receiver_terms(const SharedParameter& p, const Deployment& d) {
  Terms terms = {{parameter_name(p, d), 1.0}};
  const std::string& vehicle = d.vehicles[d.receivers[p.owner].vehicle.index()].name;
  const Eigen::Vector2d o = d.receivers[p.owner].position_m.head<2>();
  if (p.component > 1 || !(o.norm() > 0)) return terms;
  terms.emplace_back("array/" + vehicle + "/radius_m", o[p.component] / o.norm());
  terms.emplace_back("array/" + vehicle + "/turn_rad", p.component == 0 ? -o.y() : o.x());
  return terms;
}

Terms terms_of(const SharedParameter& p, const Deployment& d, const std::string& speed) {
  switch (p.quantity) {
    case Quantity::kBeaconDelay: return {{parameter_name(p, d), 1.0}, {"site/delay_s", 1.0}};
    case Quantity::kReceiverPosition: return receiver_terms(p, d);
    case Quantity::kSpeed: return {{speed, 1.0}};
    default: return {{parameter_name(p, d), 1.0}};
  }
}

/// Of several runs with an offset each the last is the nearest to the present, and its offset the
/// deployment's.
std::string speed_name(const JointCovariance& joint) {
  std::string last = "medium/speed_mps";
  for (const std::string& name : joint.parameters)
    if (name.starts_with("medium/run")) last = name;
  return last;
}

/// Of sites so large that there is no joint covariance: each beacon's own.
Eigen::MatrixXd separate_covariance(const KnownParameters& known, const Deployment& d) {
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(known.size(), known.size());
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const SharedParameter& p = known.parameters[static_cast<std::size_t>(i)];
    if (p.quantity == Quantity::kBeaconPosition)
      for (Eigen::Index j = i - p.component; j < i - p.component + 3; ++j)
        C(i, j) = d.beacons[p.owner].covariance_m2(p.component, j - i + p.component);
    if (p.quantity == Quantity::kBeaconDelay) C(i, i) = std::pow(d.beacons[p.owner].delay_sigma_s, 2);
    if (p.quantity == Quantity::kReceiverPosition)
      C(i, i) = std::pow(d.receivers[p.owner].sigma_m[p.component], 2);
    if (p.quantity == Quantity::kReceiverDelay) C(i, i) = std::pow(d.receivers[p.owner].delay_sigma_s, 2);
    if (p.quantity == Quantity::kSpeed) C(i, i) = std::pow(d.speed_sigma_mps, 2);
  }
  return C;
}

}  // namespace

int KnownParameters::index_of(const SharedParameter& parameter) const {
  const auto at = std::find(parameters.begin(), parameters.end(), parameter);
  return at == parameters.end() ? -1 : static_cast<int>(at - parameters.begin());
}

std::string parameter_name(const SharedParameter& p, const Deployment& d) {
  const auto of_receiver = [&] {
    return "receiver/" + d.vehicles[d.receivers[p.owner].vehicle.index()].name + "/" +
           d.receivers[p.owner].name;
  };
  switch (p.quantity) {
    case Quantity::kBeaconPosition:
      return "beacon/" + d.beacons[p.owner].name + kAxisNames[static_cast<std::size_t>(p.component)];
    case Quantity::kBeaconDelay: return "beacon/" + d.beacons[p.owner].name + "/delay_s";
    case Quantity::kBeaconGain: return "beacon/" + d.beacons[p.owner].name + "/log_gain";
    case Quantity::kReceiverPosition:
      return of_receiver() + kAxisNames[static_cast<std::size_t>(p.component)];
    case Quantity::kReceiverDelay: return of_receiver() + "/delay_s";
    case Quantity::kSpeed: return "medium/speed_mps";
    case Quantity::kAttenuation: return kAttenuationNames[static_cast<std::size_t>(p.component)];
    case Quantity::kClockDrift: return "vehicle/" + d.vehicles[p.owner].name + "/clock_drift";
  }
  return {};
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
  std::unordered_map<std::string, Eigen::Index> column;
  for (std::size_t k = 0; k < d.covariance.parameters.size(); ++k)
    column.emplace(d.covariance.parameters[k], static_cast<Eigen::Index>(k));
  const std::string speed = speed_name(d.covariance);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n, d.covariance.matrix.cols());
  for (Eigen::Index i = 0; i < n; ++i)
    for (const auto& [name, coefficient] : terms_of(known.parameters[static_cast<std::size_t>(i)], d, speed))
      if (const auto at = column.find(name); at != column.end()) J(i, at->second) = coefficient;
  known.covariance = J * d.covariance.matrix * J.transpose();
  return known;
}

Eigen::VectorXd drift_variances(const KnownParameters& known, const Drift& drift) {
  constexpr double kClockDrift = 1.0e-6, kHalfPowerAngle_rad = 0.02;
  Eigen::VectorXd sigma(known.size());
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const SharedParameter& p = known.parameters[static_cast<std::size_t>(i)];
    switch (p.quantity) {
      case Quantity::kBeaconPosition: sigma[i] = drift.beacon_m; break;
      case Quantity::kBeaconDelay:
      case Quantity::kReceiverDelay: sigma[i] = drift.delay_s; break;
      case Quantity::kBeaconGain: sigma[i] = drift.log_gain; break;
      case Quantity::kReceiverPosition: sigma[i] = drift.receiver_m; break;
      case Quantity::kSpeed: sigma[i] = drift.speed_mps; break;
      case Quantity::kAttenuation:
        sigma[i] = p.component == 3 ? kHalfPowerAngle_rad
                                    : drift.attenuation * std::max(1e-9, std::abs(known.value[i]));
        break;
      case Quantity::kClockDrift: sigma[i] = kClockDrift; break;
    }
  }
  return sigma.cwiseAbs2();
}

Eigen::MatrixXd map_motions(const KnownParameters& known, Motion motion) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (Eigen::Index i = 0; i < known.size(); ++i)
    if (const SharedParameter& p = known.parameters[static_cast<std::size_t>(i)];
        p.quantity == Quantity::kBeaconPosition) {
      centre[p.component] += known.value[i];
      count += 1.0 / 3.0;
    }
  centre /= std::max(count, 1.0);
  const bool planar = motion == Motion::kPlanar;
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(known.size(), planar ? 3 : 6);
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const SharedParameter& p = known.parameters[static_cast<std::size_t>(i)];
    if (p.quantity != Quantity::kBeaconPosition) continue;
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
