// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/simulator/random.h"

namespace octant::test {

/// A joint covariance with everything correlated: millimetres, microseconds, tenths of metres a second.
inline void add_covariance(Deployment& d, Random& draw) {
  auto& ids = d.covariance.parameters;
  std::vector<double> sigma;
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    for (std::size_t i = 0; i < 3; ++i)
      ids.push_back(parameters::beacon_position(b, i)), sigma.push_back(3e-3);
    ids.push_back(parameters::beacon_delay(b)), sigma.push_back(6e-6);
  }
  for (std::size_t r = 0; r < d.receivers.size(); ++r)
    for (std::size_t i = 0; i < 3; ++i)
      ids.push_back(parameters::receiver_position(r, i)), sigma.push_back(5e-4);
  ids.push_back(parameters::speed()), sigma.push_back(0.1);
  const auto n = static_cast<Eigen::Index>(ids.size());
  Eigen::MatrixXd mix(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      mix(i, j) = draw.normal() / std::sqrt(2.0 * static_cast<double>(n)) + (i == j ? std::sqrt(0.5) : 0.0);
  const Eigen::MatrixXd root = Eigen::Map<const Eigen::VectorXd>(sigma.data(), n).asDiagonal() * mix;
  d.covariance.matrix = root * root.transpose();
}

/// The deployment as a calibration with these errors would have written it.
inline Deployment with_errors(Deployment d, const Eigen::VectorXd& error) {
  Eigen::Index at = 0;
  for (auto& b : d.beacons) {
    b.position_m += error.segment<3>(at);
    b.delay_s += error[at + 3];
    at += 4;
  }
  for (auto& r : d.receivers) r.position_m += error.segment<3>(at), at += 3;
  d.speed_offset_mps += error[at];
  return d;
}

}  // namespace octant::test
