// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/simulator/random.h"
#include "tests/support/worlds.h"

namespace octant::test {

/// A deployment of the hall with a joint covariance of all but its control points.
inline Deployment calibrated_hall(bool with_attenuation = false) {
  Scenario s = hall_scenario();
  if (with_attenuation) add_attenuation(s);
  s.site.timing.delay_per.receiver = true;
  s.path.epochs = s.heldout_path.epochs = 2;
  Deployment d = must(simulate(s, 3)).truth;
  d.speed_sigma_mps = 0.4;
  d.correlated_noise = {.sigma_s = 4e-6, .time_s = 20.0, .pair_sigma_s = 3e-6};
  d.noise.pair_sigma_s = 1e-6;
  JointCovariance& joint = d.covariance;
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    if (d.beacons[b].status != BeaconStatus::kControlPoint)
      for (std::size_t i = 0; i < 3; ++i) joint.parameters.push_back(parameters::beacon_position(b, i));
    joint.parameters.push_back(parameters::beacon_delay(b));
    if (with_attenuation) {
      joint.parameters.push_back(parameters::beacon_gain(b));
      d.beacons[b].gain = 0.9;
    }
  }
  for (std::size_t r = 0; r < d.receivers.size(); ++r)
    for (std::size_t i = 0; i < 3; ++i) joint.parameters.push_back(parameters::receiver_position(r, i));
  joint.parameters.push_back(parameters::speed());
  const auto n = static_cast<Eigen::Index>(joint.parameters.size());
  Random draws(4);
  Eigen::MatrixXd A(n, n);
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = draws.normal();
  Eigen::VectorXd sigma(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ParameterKind kind = joint.parameters[static_cast<std::size_t>(i)].kind;
    sigma[i] = kind == ParameterKind::kBeaconDelay ? 1e-6 : kind == ParameterKind::kSpeed ? 0.4 : 1e-3;
  }
  joint.matrix = sigma.asDiagonal() *
                 (A * A.transpose() / static_cast<double>(n) + 0.1 * Eigen::MatrixXd::Identity(n, n)) *
                 sigma.asDiagonal();
  return d;
}

}  // namespace octant::test
