// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/statements/common_errors.h"
#include "calib/statements/refit.h"

namespace octant::calib {

/// Errors that the residuals of a fit show (common_errors.h).
[[nodiscard]] std::vector<CommonError> errors_of(const SolveOptions& options, const Fit& fit);

/// A fit to observations from which an error was taken out.
struct ErrorFit {
  CommonError error;  ///< its size as adjusted; sigmas: root of twice the gain in log likelihood
  Fit fit;
};

/// Takes an error out of the observations of a fit, adjusts them again and refines its size by the score that
/// is left (Gauss-Newton in the size). Nothing where that costs no less than before.
[[nodiscard]] std::optional<ErrorFit> fit_without(const SolveOptions& options, const Fit& fit,
                                                  CommonError error);

/// Weights the arrivals by the noise that a fit leaves, where that is far less than it was with the error in
/// them, and adjusts again: echoes that the larger noise hid are rejected then.
/// @return the noise over that before
double adjust_to_noise(const SolveOptions& options, Fit& fit);

/// Variance of the arrivals of a fit, in units of their sigmas, with what correlation within a pair adds:
/// twice a difference of costs over this is twice a difference of log likelihoods.
[[nodiscard]] double noise_variance(const Fit& fit, int threads);

}  // namespace octant::calib
