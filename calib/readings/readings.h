// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"
#include "models/contradiction.h"

namespace octant::calib {

/// Looks for the false statement behind such an outcome, one that people often get wrong: a small
/// combinatorial search over other readings (two of a few control points exchanged; receivers exchanged,
/// mirrored, turned; receivers or a map in another frame; positions, of some beacons too, in centimetres,
/// millimetres, feet, inches; two-way times; stops without epochs; poses that are mirrored or stamped late; a
/// clock that jumped), each adjusted to an evenly spread part of the recordings and held against the same
/// part as stated by a robust likelihood
/// (`sigmas`: the root of twice its logarithm). Usually one or none; several where the data cannot tell them
/// apart. Takes some dozens of quick adjustments; ends early where the options' progress says so.
[[nodiscard]] std::vector<Contradiction> find_misreadings(const Problem& problem, const Solution& solution,
                                                          const SolveOptions& options = {});

/// The same for an outcome that blames some statements and explains all else, which may be innocent: two of
/// three or four control points exchanged in place of one that is elsewhere; a clock that jumped in place of
/// delays, receivers and places that bend to it; times there and back, or units, in place of the speed.
[[nodiscard]] std::vector<Contradiction> find_other_culprits(const Problem& problem, const Solution& solution,
                                                             const SolveOptions& options = {});

}  // namespace octant::calib
