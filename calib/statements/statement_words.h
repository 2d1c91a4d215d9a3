// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/statements/refit.h"
#include "calib/statements/statement.h"
#include "models/contradiction.h"

namespace octant::calib {

/// Describes contradicted assumptions: value in the site file, value in the fit that releases all of them,
/// remedy. Two control points at each other's positions are one contradiction.
/// @param sigmas  significance of each culprit
[[nodiscard]] std::vector<Contradiction> in_words(const StatedSite& stated, const Fit& fit,
                                                  const std::vector<Statement>& culprits,
                                                  const std::vector<double>& sigmas);

}  // namespace octant::calib
