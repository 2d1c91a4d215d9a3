// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/survey_input.h"

#include <fmt/format.h>

#include "io/deployment/deployment_json.h"
#include "io/site/scene_yaml.h"
#include "io/site/site_yaml.h"
#include "io/text/bounds.h"
#include "survey/geometry/make_survey_model.h"

namespace octant::app {
namespace {

std::size_t vehicle_index(const std::vector<SiteVehicle>& vehicles, const std::string& name,
                          const std::string& path) {
  if (name.empty()) return 0;
  std::string known;
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    if (vehicles[v].name == name) return v;
    known += (known.empty() ? "" : ", ") + vehicles[v].name;
  }
  fail_with({.file = path, .found = fmt::format("vehicle '{}' is not in the file", name), .expected = known});
}

void read_scene_of(const std::string& path, const std::string& scene_path, SurveyInput& input) {
  if (!scene_path.empty()) {
    input.scene = need(io::read_scene(scene_path));
  } else if (input.site) {
    if (auto scene = need(io::read_site_scene(path))) input.scene = std::move(*scene);
  }
}

void take_model(Result<survey::SurveyModel> model, const std::string& path, SurveyInput& input,
                Session& session) {
  input.model = need(std::move(model), path);
  session.warn(input.model.warnings);
}

}  // namespace

SurveyInput read_survey_input(const std::string& path, const std::string& scene_path,
                              const std::string& vehicle, std::optional<double> cell_m, Session& session,
                              BeaconPlaces places) {
  const std::string text = need(io::read_document(path));
  SurveyInput input;
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const bool json = first != std::string::npos && text[first] == '{';
  if (json && text.find("\"octant_site\"") ==
                  std::string::npos) {  // JSON is valid YAML, so it may also be a site file
    input.deployment = need(io::deployment_from_json(text, path));
  } else {
    input.site = need(io::read_site(path));
    session.warn(input.site->warnings);
  }
  read_scene_of(path, scene_path, input);
  session.warn(input.scene.warnings);
  if (input.scene.path.empty()) input.scene.path = path;
  if (cell_m) input.scene.cell_m = *cell_m;
  const std::size_t index = vehicle_index(input.vehicles(), vehicle, path);
  input.model.vehicle = index;
  if (places == BeaconPlaces::kRecorded && input.site) return input;
  take_model(!input.site ? survey::make_survey_model(*input.deployment, input.scene, index)
             : places == BeaconPlaces::kNone
                 ? survey::make_empty_survey_model(*input.site, input.scene, index)
                 : survey::make_survey_model(*input.site, input.scene, index),
             path, input, session);
  return input;
}

void place_recorded(const std::string& path, const std::vector<bool>& placed,
                    const std::vector<Eigen::Vector3d>& p_map_m, SurveyInput& input, Session& session) {
  Site site = *input.site;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    for (std::size_t i = 0; i < 3 && placed[b]; ++i)
      site.beacons[b].position_m[i] = p_map_m[b][static_cast<Eigen::Index>(i)];
  take_model(survey::make_survey_model(site, input.scene, input.model.vehicle), path, input, session);
}

}  // namespace octant::app
