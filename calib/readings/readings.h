// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "models/contradiction.h"

namespace octant::calib {

/// Searches for a common mistake that explains such an outcome. The hypotheses are: two of a few control
/// points exchanged; receivers exchanged, mirrored or rotated; receivers or a map in another frame;
/// positions, of all or some beacons, in centimetres, millimetres, feet or inches; two-way times; stops
/// without epochs; mirrored poses or poses with a time lag; a clock that jumped. Each is adjusted to an
/// evenly spread part of the recordings, and its robust likelihood is compared with that of the original
/// inputs (`sigmas`: square root of twice the log-likelihood ratio).
///
/// Takes some dozens of quick adjustments, and ends early if the options' progress function requests it.
/// @return usually at most one contradiction; several if the data do not distinguish them
[[nodiscard]] std::vector<Contradiction> find_misreadings(const Problem& problem, const Solution& solution,
                                                          const SolveOptions& options = {});

/// Searches for other causes of an outcome whose contradictions explain everything but may be consequences:
/// two of three or four control points exchanged instead of one at another position; a clock that jumped
/// instead of delays, receivers and positions that absorb it; two-way times or units instead of the speed.
[[nodiscard]] std::vector<Contradiction> find_other_culprits(const Problem& problem, const Solution& solution,
                                                             const SolveOptions& options = {});

}  // namespace octant::calib
