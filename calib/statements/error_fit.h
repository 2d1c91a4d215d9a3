// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/statements/common_errors.h"
#include "calib/statements/refit.h"

namespace octant::calib {

/// Common errors that the residuals of a fit show (common_errors.h).
[[nodiscard]] std::vector<CommonError> errors_of(const SolveOptions& options, const Fit& fit,
                                                 double least_sigmas = kBeyondChance);

/// A fit to observations that were corrected for an error.
struct ErrorFit {
  /// With its adjusted size; sigmas: square root of twice the gain in log-likelihood under the error model
  CommonError error;
  double variance = 1.0;  ///< ratio of a difference of costs to one of log-likelihoods (variance_of_error)
  Fit fit;
};

/// Corrects the observations of a fit for an error, adjusts them again, and refines the size of the error by
/// the remaining score (Gauss-Newton in the size). Returns no value if the cost does not decrease.
[[nodiscard]] std::optional<ErrorFit> fit_without(const SolveOptions& options, const Fit& fit,
                                                  CommonError error);

/// If the noise of a fit is far below its value before the correction, weights the arrivals by it and adjusts
/// again. Echoes hidden by the larger noise are then rejected.
/// @return ratio of the noise to that before
double adjust_to_noise(const SolveOptions& options, Fit& fit);

}  // namespace octant::calib
