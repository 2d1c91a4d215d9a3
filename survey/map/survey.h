// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/deployment.h"
#include "models/scene.h"
#include "models/support/result.h"
#include "survey/geometry/survey_model.h"
#include "survey/map/survey_result.h"

namespace octant::survey {

/// Evaluates every cell and every route.
/// @param deployment  that of the model, for the calibration's part; null: the site is not calibrated yet
/// Errors: those of make_floor_grid.
[[nodiscard]] Result<Survey> run_survey(const SurveyModel& model, const Scene& scene,
                                        const Deployment* deployment, const SurveyOptions& options = {});

}  // namespace octant::survey
