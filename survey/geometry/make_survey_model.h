// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/deployment.h"
#include "models/scene.h"
#include "models/site.h"
#include "models/support/result.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

/// Builds the model of a site or a deployment for a survey. Beacons without a position (or undetermined ones)
/// are left out with a warning.
/// @param vehicle  index of the vehicle whose receivers are used
/// Errors: no beacon with a position, no receivers; the findings of check_scene; a beacon of the scene that
/// the site does not have.
[[nodiscard]] Result<SurveyModel> make_survey_model(const Site& site, const Scene& scene,
                                                    std::size_t vehicle = 0);
[[nodiscard]] Result<SurveyModel> make_survey_model(const Deployment& deployment, const Scene& scene,
                                                    std::size_t vehicle = 0);
/// Builds the model without beacons, for searches that place all of them. Further error: the scene has no
/// floor.
[[nodiscard]] Result<SurveyModel> make_empty_survey_model(Site site, Scene scene, std::size_t vehicle = 0);

}  // namespace octant::survey
