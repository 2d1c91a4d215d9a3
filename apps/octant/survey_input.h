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

/// A site or a deployment with its scene, as input of the commands that evaluate geometry.
struct SurveyInput {
  std::optional<Site> site;  ///< exactly one of both is set
  std::optional<Deployment> deployment;
  Scene scene;  ///< from --scene, else from the site file, else the default
  survey::SurveyModel model;
  [[nodiscard]] NameTable names() const { return site ? names_of(*site) : names_of(*deployment); }
  [[nodiscard]] const std::vector<SiteVehicle>& vehicles() const {
    return site ? site->vehicles : deployment->vehicles;
  }
};

/// Source of the beacons' positions in the model.
enum class BeaconPlaces {
  kStated,   ///< positions in the file
  kNone,     ///< no beacons, even if the site has some: their positions are to be planned (site files only)
  kRecorded  ///< recordings will determine the positions, so the model is built later (site files only)
};

/// Reads a site file or a deployment (JSON without octant_site) and the scene. Warnings go to the session.
/// @param scene_path  file with a scene only; empty: the site's own scene
/// @param vehicle  name; empty: the first vehicle
/// @param cell_m  overrides the scene's cell size
[[nodiscard]] SurveyInput read_survey_input(const std::string& path, const std::string& scene_path,
                                            const std::string& vehicle, std::optional<double> cell_m,
                                            Session& session, BeaconPlaces places = BeaconPlaces::kStated);

/// Model of a site whose beacons were found from recordings. Warnings go to the session.
/// @param path  path of the site file  @param placed  marks the beacons with a valid entry in p_map_m
void place_recorded(const std::string& path, const std::vector<bool>& placed,
                    const std::vector<Eigen::Vector3d>& p_map_m, SurveyInput& input, Session& session);

}  // namespace octant::app
