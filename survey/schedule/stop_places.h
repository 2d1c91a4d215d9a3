// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "models/scene.h"
#include "models/support/result.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

/// Where a vehicle may stop.
struct StopPlaces {
  std::vector<Eigen::Vector2d> places_m;                 ///< a grid over the floor
  double spacing_m = 1.0;                                ///< spacing of the grid
  std::function<bool(const Eigen::Vector2d&)> may_stop;  ///< anywhere; owns what it needs
};

/// Places on the floor, clearance_m from its edge and from what is in a vehicle's way.
/// @param spacing_m  0: some 120 places, a metre apart at least
/// Errors: more than 2e5 places, not a single one.
[[nodiscard]] Result<StopPlaces> stop_places(const SurveyModel& model, const Scene& scene, double spacing_m,
                                             double clearance_m);

}  // namespace octant::survey
