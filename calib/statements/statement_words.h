// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/statements/refit.h"
#include "calib/statements/statement.h"
#include "models/contradiction.h"

namespace octant::calib {

/// Contradictions of the labels of two beacons, and of the sign of all heights, without `sigmas`.
[[nodiscard]] Contradiction exchange_in_words(const SiteBeacon& a, const SiteBeacon& b);
[[nodiscard]] Contradiction heights_in_words();

/// Describes contradicted assumptions: value in the site file, value in the fit that releases all of them,
/// remedy.
/// @param sigmas  significance of each culprit
[[nodiscard]] std::vector<Contradiction> in_words(const StatedSite& stated, const Fit& fit,
                                                  const std::vector<Statement>& culprits,
                                                  const std::vector<double>& sigmas);

}  // namespace octant::calib
