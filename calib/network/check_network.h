// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/network/network.h"
#include "models/support/result.h"

namespace octant::calib {

/// Checks a network before its adjustment. Errors: kBadInput with the line of the observation, for indices
/// out of range, values and standard deviations that are not valid, covariance matrices that are not positive
/// definite or overlap, an observation between coincident points, and a network without adjusted coordinates.
[[nodiscard]] Result<void> check_network(const Network& network);

}  // namespace octant::calib
