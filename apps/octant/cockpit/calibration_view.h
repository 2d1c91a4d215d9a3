// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "apps/octant/session.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/survey_input.h"
#include "models/deployment.h"

namespace octant::app {

/// One calibration of the rows so far, as the page shows it (schema `cockpit`, key `calibration`).
struct CalibrationView {
  Json calibration = nullptr;                    ///< null before the first one
  Json next_stop = nullptr;                      ///< null if no stop is planned
  std::string floor;                             ///< answer of /api/floor; empty without a map
  std::optional<survey::SurveyModel> model;      ///< geometry for maps with other places of beacons
  Scene scene;                                   ///< of the model
  std::shared_ptr<const Deployment> deployment;  ///< for the vehicle's position; null without one
  std::string message;                           ///< reason for which there is no calibration yet
};

/// Calibrates a run folder as `octant calibrate` does and judges the result. Never fails: a run that cannot
/// be calibrated yet has a message.
[[nodiscard]] CalibrationView calibration_view(const std::string& site, const std::string& run,
                                               const Session& session);

/// Map of the expected error of a fix on the floor; empty if the geometry does not determine a fix.
/// @param deployment  for the calibration's part; null: the arrivals' noise only
[[nodiscard]] std::string floor_json(survey::SurveyModel model, Scene scene, const Deployment* deployment,
                                     int threads);

/// Calibrates the complete run and writes site.yaml, deployment.json and report.html into its folder.
/// @param accept  exports a deployment that the data contradict, marked
/// @return key `finished` of the state
[[nodiscard]] Json finish_commissioning(const std::string& site, const std::string& run, bool accept,
                                        const Session& session);

}  // namespace octant::app
