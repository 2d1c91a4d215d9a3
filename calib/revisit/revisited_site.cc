// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/revisited_site.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/deployed_site.h"
#include "models/changes/change_sigmas.h"
#include "models/parameter.h"

namespace octant::calib {
namespace {

/// Writes the known value of a parameter as a prior of the site. Visitor: see visit_parameter. The shape of
/// an array is in its receivers and the site's delay in its beacons; biases of pairs are omitted.
struct PriorOfSite : HasNothing<void> {
  Site& site;
  const Deployment& d;
  Prior prior;
  PriorOfSite(Site& of, const Deployment& from, Prior known) : site(of), d(from), prior(known) {}
  void beacon_position(std::size_t b, std::size_t axis) const {
    site.beacons[b].position_m[axis] = prior.value;
    site.beacons[b].sigma_m[axis] = prior.sigma;
  }
  void beacon_delay(std::size_t b) const {
    site.beacons[b].delay_s = prior.value;
    site.beacons[b].delay_sigma_s = prior.sigma;
    site.timing.delay_per.beacon = true;
  }
  void beacon_gain(std::size_t b) const { site.beacons[b].log_gain = prior; }
  void receiver_position(std::size_t r, std::size_t axis) const {
    site.receivers[r].sigma_m[static_cast<Eigen::Index>(axis)] = prior.sigma;
  }
  void receiver_delay(std::size_t) const {
    site.timing.delay_sigma_s = std::max({site.timing.delay_sigma_s, std::abs(prior.value), prior.sigma});
  }
  // The offset starts at zero, so its sigma includes its known value.
  void speed(std::size_t) const { site.speed_sigma_mps = std::hypot(prior.sigma, prior.value); }
  void attenuation(std::size_t unknown) const { attenuation_unknown(*site.attenuation, unknown) = prior; }
  void clock_drift(std::size_t) const {
    site.timing.drift = d.timing.drift;
    site.timing.drift_sigma =
        std::max({site.timing.drift_sigma, std::abs(prior.value - d.timing.drift), prior.sigma});
  }
};

}  // namespace

Eigen::VectorXd room_for_change(const KnownParameters& known) {
  const ChangeSigmas room = usual_changes(known.speed_mps);
  Eigen::VectorXd sigma(known.size());
  for (Eigen::Index k = 0; k < known.size(); ++k)
    sigma[k] = room.of(known.parameters[static_cast<std::size_t>(k)]);
  return sigma.cwiseAbs2();
}

Site revisited_site(const Deployment& d, const KnownParameters& known, const Eigen::VectorXd& variance) {
  Site site = deployed_site(d);
  site.timing.delay_per.site = false;  // the beacons contain it
  site.noise.tof_sigma_s =
      std::hypot(d.noise.tof_sigma_s, d.correlated_noise.sigma_s, d.correlated_noise.pair_sigma_s);
  for (Eigen::Index k = 0; k < known.size(); ++k)
    visit_parameter(known.parameters[static_cast<std::size_t>(k)],
                    PriorOfSite(site, d, {known.value[k], std::sqrt(variance[k])}));
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
  std::vector<std::pair<int, int>> order;  // ascending columns with their parameters
  for (std::size_t k = 0; k < column.size(); ++k)
    if (column[k] >= 0) order.emplace_back(column[k], static_cast<int>(k));
  std::ranges::sort(order);
  const auto n = static_cast<Eigen::Index>(order.size());
  std::vector<int> columns, which;
  Eigen::VectorXd unit(n);
  for (const auto& [c, k] : order) {
    Parameter& parameter = layout.parameter(c);
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
