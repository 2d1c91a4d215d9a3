// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/calibrate.h"

namespace octant::calib {

/// Whether a calibration came out as one does whose site file or log is wrong as a whole: no or a poor
/// outcome, many arrivals left out, more than a few of them early, which no echo can be, noise many times the
/// stated one, or a receiver dragged from its place.
[[nodiscard]] bool seems_misread(const Problem& problem, const Solution& solution);

}  // namespace octant::calib
