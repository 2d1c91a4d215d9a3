// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/statements/refit.h"
#include "calib/statements/statement.h"
#include "models/contradiction.h"

namespace octant::calib {

/// Statements that the data contradict, in words: what was stated, what the fit in which none of them is
/// believed finds, what to do about it. Two control points that were found at each other's places are one.
/// @param culprits  with the sigmas by which they are contradicted, side by side
[[nodiscard]] std::vector<Contradiction> in_words(const StatedSite& stated, const Fit& fit,
                                                  const std::vector<Statement>& culprits,
                                                  const std::vector<double>& sigmas);

}  // namespace octant::calib
