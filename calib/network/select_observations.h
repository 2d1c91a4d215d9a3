// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/network/network.h"

namespace octant::calib {

/// Removes observations with their rows in covariance matrices. Sets, scales and constants without
/// observations are removed, and the others renumbered.
void keep_observations(Network& network, const std::vector<bool>& keep);

/// Removes observations that cannot be used, with their rows in covariance matrices, and returns their
/// number: a point has no role or no known coordinate that the observation depends on, or a set of directions
/// has a single target. A zenith angle needs positions in the plane that are known, with or without a role.
/// @param need_coordinates  false before approximate coordinates are computed: roles alone decide
std::size_t remove_unusable(Network& network, bool need_coordinates);

/// Removes observations whose misclosure at the approximate coordinates exceeds the limit, and returns them.
/// The misclosure of an angle counts at the distance of its target.
std::vector<SurveyObservation> remove_outlying(Network& network, double limit_m);

}  // namespace octant::calib
