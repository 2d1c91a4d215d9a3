// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "apps/octant/survey_input.h"
#include "calib/calibrate.h"
#include "calib/plan/station_information.h"

namespace octant::app {

/// Information available before the next stops, and the range of reception.
struct KnownBefore {
  calib::Knowledge knowledge;
  calib::HearingModel hearing;
  std::optional<PoseAccuracy> measured_poses;  ///< set if the recordings have poses of a total station
};

/// Information from recordings, and the reception that they show. Errors: those of knowledge_of().
[[nodiscard]] Result<KnownBefore> known_from(const calib::Calibration& calibration, int threads);

/// Restricts reception by the walls and beam patterns of the scene, for the beacons of the model.
/// @param model  must outlive the hearing
void restrict_by_scene(const SurveyInput& input, const survey::SurveyModel& model,
                       calib::HearingModel& hearing);

}  // namespace octant::app
