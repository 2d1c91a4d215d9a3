// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/deployment.h"
#include "models/parameter.h"

namespace octant {

/// Value of a shared parameter in a deployment, with its standard deviation.
struct DeploymentNumber {
  double value = 0.0;
  double sigma = 0.0;  ///< 0 if the deployment has no sigma for the value
};

/// Value of a parameter in a deployment. 0 for parameters that it does not store: an array acts through its
/// receivers, a common delay through the beacons, and biases of pairs are not stored.
[[nodiscard]] DeploymentNumber number_in(const Deployment& deployment, const ParameterId& id);

/// Writes a value, and its sigma if the deployment has one. No effect if it does not store the parameter.
void set_number(const ParameterId& id, const DeploymentNumber& number, Deployment& deployment);

}  // namespace octant
