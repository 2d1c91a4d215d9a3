// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/scene.h"
#include "models/support/result.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

/// Largest distance of a beacon outside the floor's outline or within a wall: plans and beacons are usually
/// not measured together.
inline constexpr double kOutside_m = 0.25;

/// Errors, with the name and line of the element: a floor or obstacle with fewer than three corners, without
/// area, or with crossing sides; walls, mounts and routes without length or height; routes outside the floor;
/// a cell size that is not positive; numbers that are not finite; patterns whose angles do not increase or
/// that never receive.
[[nodiscard]] Result<void> check_scene(const Scene& scene);

/// Errors: a beacon outside the floor or within something solid. @param sigma_m  of each beacon's place,
/// which is allowed for
[[nodiscard]] Result<void> check_beacon_places(const Scene& scene, const SurveyModel& model,
                                               const std::vector<double>& sigma_m);

}  // namespace octant::survey
