// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/revisited_site.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace octant::calib {
namespace {

void add_known(const Deployment& d, const KnownParameters& known, const Eigen::VectorXd& variance,
               Site& site) {
  for (Eigen::Index k = 0; k < known.size(); ++k) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(k)];
    const Prior prior{known.value[k], std::sqrt(variance[k])};
    const auto i = static_cast<std::size_t>(p.component);
    switch (p.kind) {
      case ParameterKind::kBeaconPosition:
        site.beacons[p.owner].position_m[i] = prior.value;
        site.beacons[p.owner].sigma_m[i] = prior.sigma;
        break;
      case ParameterKind::kBeaconDelay:
        site.beacons[p.owner].delay_s = prior.value;
        site.beacons[p.owner].delay_sigma_s = prior.sigma;
        site.timing.delay_per.beacon = true;
        break;
      case ParameterKind::kBeaconGain: site.beacons[p.owner].log_gain = prior; break;
      case ParameterKind::kReceiverPosition:
        site.receivers[p.owner].sigma_m[p.component] = prior.sigma;
        break;
      case ParameterKind::kReceiverDelay:
        site.timing.delay_sigma_s = std::max({site.timing.delay_sigma_s, std::abs(prior.value), prior.sigma});
        break;
      // The offset starts at nothing, and is known to be what it was.
      case ParameterKind::kSpeed: site.speed_sigma_mps = std::hypot(prior.sigma, prior.value); break;
      case ParameterKind::kAttenuation: attenuation_unknown(*site.attenuation, i) = prior; break;
      case ParameterKind::kClockDrift:
        site.timing.drift = d.timing.drift;
        site.timing.drift_sigma =
            std::max({site.timing.drift_sigma, std::abs(prior.value - d.timing.drift), prior.sigma});
        break;
      case ParameterKind::kArray:  // it stands on the receivers
      case ParameterKind::kSiteDelay:
      case ParameterKind::kPairBias: break;
    }
  }
}

}  // namespace

Eigen::VectorXd room_for_change(const KnownParameters& known, const RoomForChange& room) {
  Eigen::VectorXd sigma(known.size());
  for (Eigen::Index k = 0; k < known.size(); ++k) {
    switch (known.parameters[static_cast<std::size_t>(k)].kind) {
      case ParameterKind::kBeaconPosition: sigma[k] = room.beacon_m; break;
      case ParameterKind::kBeaconDelay: sigma[k] = room.delay_s; break;
      case ParameterKind::kReceiverPosition: sigma[k] = room.receiver_m; break;
      case ParameterKind::kSpeed: sigma[k] = room.speed_mps; break;
      case ParameterKind::kBeaconGain: sigma[k] = room.log_gain; break;
      default: sigma[k] = 0.0;
    }
  }
  return sigma.cwiseAbs2();
}

Site revisited_site(const Deployment& d, const KnownParameters& known, const Eigen::VectorXd& variance) {
  Site site;
  site.name = d.site;
  site.motion = d.motion;
  site.medium = d.medium;
  site.timing = d.timing;
  site.timing.delay_per.site = false;  // it stands on the beacons
  site.noise = d.noise;
  site.noise.tof_sigma_s =
      std::hypot(d.noise.tof_sigma_s, d.correlated_noise.sigma_s, d.correlated_noise.pair_sigma_s);
  site.noise.pair_sigma_s.reset();
  site.tolerance = d.tolerance;
  if (d.attenuation) {
    site.attenuation.emplace();
    site.attenuation->threshold_v = d.attenuation->threshold_v;
    site.attenuation->saturation_v = d.attenuation->saturation_v;
  }
  for (const DeploymentBeacon& b : d.beacons) {
    SiteBeacon beacon;
    beacon.name = b.name;
    site.beacons.push_back(std::move(beacon));
  }
  site.vehicles = d.vehicles;
  for (const DeploymentReceiver& r : d.receivers)
    site.receivers.push_back(
        {.name = r.name, .vehicle = r.vehicle, .position_m = r.position_m, .axis = r.axis});
  add_known(d, known, variance, site);
  return site;
}

std::vector<int> columns_of(const ParameterLayout& layout, const KnownParameters& known) {
  std::vector<int> columns;
  for (const ParameterId& p : known.parameters) columns.push_back(layout.column_of(p));
  return columns;
}

void set_joint_prior(ParameterLayout& layout, const KnownParameters& known,
                     const Eigen::MatrixXd& covariance) {
  const std::vector<int> column = columns_of(layout, known);
  std::vector<std::pair<int, int>> order;  // columns ascending, and their parameters
  for (std::size_t k = 0; k < column.size(); ++k)
    if (column[k] >= 0) order.emplace_back(column[k], static_cast<int>(k));
  std::sort(order.begin(), order.end());
  const auto n = static_cast<Eigen::Index>(order.size());
  std::vector<int> columns, which;
  Eigen::VectorXd unit(n);
  for (const auto& [c, k] : order) {
    Parameter& parameter = layout.parameters[static_cast<std::size_t>(c)];
    unit[static_cast<Eigen::Index>(columns.size())] = parameter.si_per_unit;
    parameter.prior_sigma = INFINITY;
    columns.push_back(c);
    which.push_back(k);
  }
  const Eigen::VectorXd per = unit.cwiseInverse();
  layout.joint_prior = joint_prior(std::move(columns), per.cwiseProduct(known.value(which)),
                                   per.asDiagonal() * covariance(which, which) * per.asDiagonal());
}

}  // namespace octant::calib
