// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/problem/problem.h"
#include "models/deployment.h"

namespace octant::calib {

/// What fixes position, orientation and scale of the map, in words and as data: control points first, then
/// measured poses, approximate positions (priors), taped distances; what nothing fixes is said so.
[[nodiscard]] Datum datum_of(const Problem& problem);

/// The same for a map that turned out to hang on nothing: inner constraints carry what was said to carry it.
void set_free_network(Datum& datum);

}  // namespace octant::calib
