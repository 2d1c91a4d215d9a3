// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/solution/solve_options.h"
#include "calib/statements/refit.h"
#include "models/contradiction.h"

namespace octant::calib {

/// Inconsistencies within the recordings.
struct Agreement {
  std::vector<Contradiction>
      contradictions;  ///< beacons that moved, that are early, or whose bearings disagree
  /// Beacons that are late at some places, stops during which the vehicle moved
  std::vector<std::string> warnings;
};

/// Finds:
/// - A beacon that moved. Its arrivals before and after some time get separate positions. These differ
///   significantly and by a relevant length, and more arrivals agree.
/// - A beacon with many early arrivals, which echoes cannot cause.
/// - A receiver that loses most of its arrivals, while the others lose hardly any.
/// - A beacon that is late much more often than the others, because of an obstacle.
/// - A stop during which the vehicle moved. Two poses, before and after some time, explain what one pose
///   cannot.
/// @param fit  fit in which all contradicted assumptions are released
/// @param besides  contradictions found already, which are not repeated
[[nodiscard]] Agreement agreement_of(const Problem& problem, const SolveOptions& options, const Fit& fit,
                                     const std::vector<Contradiction>& besides);

/// A beacon that moved, if that alone explains more than a cost (Fit::cost). A move bends delays and
/// positions that are assumed to be constant.
/// @param fit  with all assumptions of the site file
[[nodiscard]] std::vector<Contradiction> moves_of(const Problem& problem, const SolveOptions& options,
                                                  const Fit& fit, double cost);

}  // namespace octant::calib
