// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/deployment.h"
#include "models/parameter.h"

namespace octant {

/// A number of a deployment that all arrivals share, and its standard deviation.
struct DeploymentNumber {
  double value = 0.0;
  double sigma = 0.0;  ///< 0 where the deployment states none beside the value
};

/// What a deployment holds of a parameter; 0 of what it does not hold: an array as a whole stands on its
/// receivers, a site's one delay on the beacons, and biases of pairs are forgotten.
[[nodiscard]] DeploymentNumber number_in(const Deployment& deployment, const ParameterId& id);

/// Writes it, its sigma where the deployment has room for one; nothing where it holds no such parameter.
void set_number(const ParameterId& id, const DeploymentNumber& number, Deployment& deployment);

}  // namespace octant
