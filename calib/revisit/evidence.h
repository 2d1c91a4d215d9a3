// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calib/statements/refit.h"
#include "models/changes/change_search.h"
#include "models/changes/known_parameters.h"
#include "models/deployment.h"

namespace octant::calib {

/// Sum of squares that a fit leaves, in which no arrival counts for more than limit^2: two explanations of a
/// visit are compared by it.
/// @param noise_ratio  noise of the fit over the noise that both are compared at
[[nodiscard]] double truncated_squares(const Fit& fit, double limit, double noise_ratio);

/// Price of the changes in a search: the squares that each of them would explain by chance with a probability
/// of kFalseAlarm over the number of hypotheses.
[[nodiscard]] double price_of(const ChangeSearch& search);

/// Truncated squares that a change of one hypothesis could explain at most.
[[nodiscard]] double possible_gain(const Fit& fit, const ChangeHypothesis& hypothesis, double limit);

/// Returns true if more than one stop (or second of a drive) supports a change of a beacon or receiver. An
/// echo at a single stop looks like a change. The best stop is left out of the squares that the change
/// explains.
[[nodiscard]] bool is_supported(const Fit& fit, const Deployment& before, const ChangeHypothesis& hypothesis,
                                double limit);

/// Beacons that were received at a single stop (or second of a drive), by name.
[[nodiscard]] std::vector<std::string> received_once(const Fit& fit, const Deployment& before);

}  // namespace octant::calib
