// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "apps/octant/session.h"
#include "models/deployment.h"
#include "models/scene.h"
#include "models/site.h"
#include "survey/geometry/survey_model.h"

namespace octant::app {

/// A site or a deployment with its scene, as the commands that look at geometry take it.
struct SurveyInput {
  std::optional<Site> site;  ///< one of both
  std::optional<Deployment> deployment;
  Scene scene;  ///< of --scene, else of the site file's block, else all defaults
  survey::SurveyModel model;
};

/// Reads a site file or a deployment (told apart by their first character) and the scene; warnings go to the
/// session.
/// @param scene_path  file with a scene alone; empty: the site's own
/// @param vehicle  name; empty: the first one
/// @param cell_m  goes before the scene's
/// @param without_beacons  the model has none, whatever the site has: for whoever looks for their places
/// (site files only)
[[nodiscard]] Result<SurveyInput> read_survey_input(const std::string& path, const std::string& scene_path,
                                                    const std::string& vehicle, std::optional<double> cell_m,
                                                    Session& session, bool without_beacons = false);

}  // namespace octant::app
