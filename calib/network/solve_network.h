// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "calib/network/adjust_network.h"
#include "models/support/result.h"

namespace octant::calib {

struct SolveNetworkOptions {
  NetworkOptions adjustment;
  /// Observations with a larger misclosure at the approximate coordinates are left out.
  double outlier_limit_m = std::numeric_limits<double>::infinity();
};

/// Network as adjusted: coordinates that the observations do not determine have no role any more.
struct SolvedNetwork {
  Network network;
  NetworkSolution solution;
  std::vector<std::string> computed;      ///< points with an approximate coordinate that was computed
  std::vector<std::string> unlocated;     ///< points left out: no approximate coordinates
  std::vector<std::string> undetermined;  ///< points left out: neither observations nor datum determine them
  std::size_t unusable = 0;               ///< observations left out because of their points
  std::vector<SurveyObservation> outlying;
};

/// Checks a network, computes missing approximate coordinates, leaves out what cannot be used, and adjusts
/// the rest. The status is kUndetermined if no determined point remains. Errors: kBadInput, as check_network.
[[nodiscard]] Result<SolvedNetwork> solve_network(Network network, const SolveNetworkOptions& options = {});

}  // namespace octant::calib
