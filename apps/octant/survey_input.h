// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

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
  [[nodiscard]] NameTable names() const { return site ? names_of(*site) : names_of(*deployment); }
  [[nodiscard]] const std::vector<SiteVehicle>& vehicles() const {
    return site ? site->vehicles : deployment->vehicles;
  }
};

/// Where the model's beacons stand.
enum class BeaconPlaces {
  kStated,   ///< where the file has them
  kNone,     ///< it has none, whatever the site has: for whoever looks for their places (site files only)
  kRecorded  ///< where recordings will find them: the model is not made yet (site files only)
};

/// Reads a site file or a deployment (a deployment is JSON that does not say octant_site) and the scene;
/// warnings go to the session.
/// @param scene_path  file with a scene alone; empty: the site's own
/// @param vehicle  name; empty: the first one
/// @param cell_m  goes before the scene's
[[nodiscard]] SurveyInput read_survey_input(const std::string& path, const std::string& scene_path,
                                            const std::string& vehicle, std::optional<double> cell_m,
                                            Session& session, BeaconPlaces places = BeaconPlaces::kStated);

/// The model of a site whose beacons recordings have found. Warnings go to the session.
/// @param path  of the site file  @param placed  which beacons, each at its entry of p_map_m
void place_recorded(const std::string& path, const std::vector<bool>& placed,
                    const std::vector<Eigen::Vector3d>& p_map_m, SurveyInput& input, Session& session);

}  // namespace octant::app
