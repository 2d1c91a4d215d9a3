// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/adjust/estimate.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// Arrivals with correlated errors determine less than their number promises. An adjustment that weights them
/// as white overrules correct priors, and sigmas of its estimates can exceed those of the priors. Priors are
/// therefore weighted by what the arrivals determine under the error model of the recording.

/// Factor by which correlated errors increase the sigmas that the arrivals alone determine: median over the
/// parameters for which the prior matters. Returns 1 if errors are white, or if all sigmas are far below
/// those of the priors.
[[nodiscard]] double growth_against_priors(const ParameterLayout& layout, const Solution& solution);

/// The estimate with the sigmas of the priors divided by the growth, to be adjusted again.
[[nodiscard]] Estimate with_weighted_priors(Estimate estimate, double growth);

/// Replaces estimate, states and covariance of a solution by those of the adjustment with weighted priors.
/// The covariance is that of this estimator under the priors as stated and the errors of the arrivals. If few
/// data determine the error model, such weights can be worse than those of white noise: the solution is left
/// as it is if its sigmas are smaller.
/// @param layout  with the priors as stated
void adopt_if_better(const ParameterLayout& layout, double growth, Solution weighted, Solution& solution);

}  // namespace octant::calib
