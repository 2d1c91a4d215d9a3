// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/physics/pose.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

/// Whether one receiver hears one beacon: range, threshold, both patterns, and nothing that stops sound
/// between them. One path at a time; for many poses there is heard_at() (geometry_map.h).
[[nodiscard]] bool hears(const SurveyModel& model, std::size_t beacon, std::size_t receiver,
                         const Pose& T_map_vehicle);

}  // namespace octant::survey
