// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "survey/map/survey.h"

namespace octant::survey {

/// All maps as CSV: x_m, y_m, a column for each map (empty: no fix), `heard`: names of the received beacons,
/// separated by ';'.
[[nodiscard]] std::string survey_csv(const Survey& survey);
/// The maps along all routes as CSV: the columns route, x_m, y_m, heading_rad come first.
[[nodiscard]] std::string routes_csv(const Survey& survey);

}  // namespace octant::survey
