// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "survey/drawing/site_plan.h"
#include "survey/map/survey.h"

namespace octant::survey {

/// Plan of a survey: floor, walls that block sound, routes, beacons, and some of the maps. Lengths are in
/// millimetres, as tolerances usually are.
/// @param most_bins  along the longer side; a bin has the worst value of its cells
[[nodiscard]] PlanInput survey_plan(const Survey& survey, const std::vector<const FloorMap*>& maps,
                                    std::size_t most_bins);

}  // namespace octant::survey
