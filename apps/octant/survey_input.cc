// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/survey_input.h"

#include <fmt/format.h>

#include "io/deployment/deployment_json.h"
#include "io/site/scene_yaml.h"
#include "io/site/site_yaml.h"
#include "io/text/bounds.h"

namespace octant::app {
namespace {

Result<std::size_t> vehicle_index(const std::vector<SiteVehicle>& vehicles, const std::string& name,
                                  const std::string& path) {
  if (name.empty()) return std::size_t{0};
  std::string known;
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    if (vehicles[v].name == name) return v;
    known += (known.empty() ? "" : ", ") + vehicles[v].name;
  }
  return fail(
      {.file = path, .found = fmt::format("vehicle '{}' is not in the file", name), .expected = known});
}

Result<void> read_scene_of(const std::string& path, const std::string& scene_path, SurveyInput& input) {
  if (!scene_path.empty()) {
    auto scene = io::read_scene(scene_path);
    if (!scene) return fail(scene.error());
    input.scene = std::move(*scene);
  } else if (input.site) {
    auto scene = io::read_site_scene(path);
    if (!scene) return fail(scene.error());
    if (*scene) input.scene = std::move(**scene);
  }
  return {};
}

Result<void> take_model(Result<survey::SurveyModel> model, const std::string& path, SurveyInput& input,
                        Session& session) {
  if (!model) {
    Error error = model.error();
    if (error.file.empty()) error.file = path;
    return fail(error);
  }
  session.warn(model->warnings);
  input.model = std::move(*model);
  return {};
}

}  // namespace

Result<SurveyInput> read_survey_input(const std::string& path, const std::string& scene_path,
                                      const std::string& vehicle, std::optional<double> cell_m,
                                      Session& session, BeaconPlaces places) {
  const auto text = io::read_document(path);
  if (!text) return fail(text.error());
  SurveyInput input;
  const std::size_t first = text->find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const bool json = first != std::string::npos && (*text)[first] == '{';
  if (json && text->find("\"octant_site\"") == std::string::npos) {  // JSON is YAML: a site may be written so
    auto deployment = io::deployment_from_json(*text, path);
    if (!deployment) return fail(deployment.error());
    input.deployment = std::move(*deployment);
  } else {
    auto site = io::read_site(path);
    if (!site) return fail(site.error());
    session.warn(site->warnings);
    input.site = std::move(*site);
  }
  if (auto read = read_scene_of(path, scene_path, input); !read) return fail(read.error());
  session.warn(input.scene.warnings);
  if (input.scene.path.empty()) input.scene.path = path;
  if (cell_m) input.scene.cell_m = *cell_m;
  const auto index =
      vehicle_index(input.site ? input.site->vehicles : input.deployment->vehicles, vehicle, path);
  if (!index) return fail(index.error());
  input.model.vehicle = *index;
  if (places == BeaconPlaces::kRecorded && input.site) return input;
  auto model = !input.site ? survey::make_survey_model(*input.deployment, input.scene, *index)
               : places == BeaconPlaces::kNone
                   ? survey::make_empty_survey_model(*input.site, input.scene, *index)
                   : survey::make_survey_model(*input.site, input.scene, *index);
  if (auto taken = take_model(std::move(model), path, input, session); !taken) return fail(taken.error());
  return input;
}

Result<void> place_recorded(const std::string& path, const std::vector<bool>& placed,
                            const std::vector<Eigen::Vector3d>& p_map_m, SurveyInput& input,
                            Session& session) {
  Site site = *input.site;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    for (std::size_t i = 0; i < 3 && placed[b]; ++i)
      site.beacons[b].position_m[i] = p_map_m[b][static_cast<Eigen::Index>(i)];
  return take_model(survey::make_survey_model(site, input.scene, input.model.vehicle), path, input, session);
}

}  // namespace octant::app
