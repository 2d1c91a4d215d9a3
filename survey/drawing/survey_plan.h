// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "survey/drawing/site_plan.h"
#include "survey/map/survey.h"

namespace octant::survey {

/// What a survey looked at, as a plan draws it: floor, walls that stop sound, routes, beacons, and some of
/// its maps. Lengths are in millimetres, as tolerances are spoken of.
/// @param most_bins  along the longer side; a bin holds the worst of its cells
[[nodiscard]] PlanInput survey_plan(const Survey& survey, const std::vector<const FloorMap*>& maps,
                                    std::size_t most_bins);

}  // namespace octant::survey
