// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/solution/solve_options.h"
#include "calib/statements/refit.h"
#include "models/contradiction.h"

namespace octant::calib {

/// Whether the recording agrees with itself.
struct Agreement {
  std::vector<Contradiction>
      contradictions;  ///< a beacon that moved, whose arrivals come early, whose bearings fit nowhere
  std::vector<std::string> warnings;  ///< beacons heard late at some places, stops that were none
};

/// - A beacon that moved: its arrivals before and after some time are given places of their own; they differ
/// beyond chance, by a length
///   that matters, and more arrivals agree.
/// - A beacon much of which comes early: no echo does.
/// - A receiver most of whose arrivals are left out, where hardly any of the others are.
/// - A beacon that is late much more often than the others: something stands in its way.
/// - A stop during which the vehicle moved: two poses, one before and one after some time, explain what one
/// cannot.
/// @param fit  in which nothing that the data contradict is believed any more
/// @param besides  what is contradicted already, which is not said again
/// @param growth  of sigmas by errors that are correlated (error_model.h): a move has to be that much clearer
[[nodiscard]] Agreement agreement_of(const Problem& problem, const SolveOptions& options, const Fit& fit,
                                     const std::vector<Contradiction>& besides, double growth = 1.0);

}  // namespace octant::calib
