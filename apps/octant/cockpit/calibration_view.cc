// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/calibration_view.h"

#include <algorithm>
#include <cmath>

#include "apps/octant/cockpit/stop_plan.h"
#include "apps/octant/steps/reporting.h"
#include "io/text/atomic_file.h"
#include "models/physics/polygon.h"
#include "models/trajectory/trajectory.h"
#include "survey/geometry/make_survey_model.h"
#include "survey/map/survey.h"
#include "survey/report/report_sections.h"

namespace octant::app {
namespace {

constexpr std::size_t kMostShownStops = 2000;
constexpr double kMostFloorCells = 2500;
constexpr std::size_t kViewMemory_mb = 300;

Json beacon_views_json(const survey::ReportInput& input) {
  Json beacons = Json::array();
  const Deployment& d = input.plan.deployment;
  for (const DeploymentBeacon& b : d.beacons) {
    Json beacon = {{"id", b.name}, {"status", to_string(b.status)}};
    if (b.status != BeaconStatus::kUndetermined || b.covariance_m2.trace() > 0) {
      beacon["position_m"] = b.position_m;
      beacon["covariance_xy_m2"] = {b.covariance_m2(0, 0), b.covariance_m2(0, 1), b.covariance_m2(1, 1)};
      beacon["sigma_m"] = Eigen::Vector3d(b.covariance_m2.diagonal().cwiseMax(0.0).cwiseSqrt());
      beacon["radius95_m"] = survey::radius95_m(b);
      beacon["delay_s"] = b.delay_s;
    }
    for (const survey::BeaconNote& note : input.beacons)
      if (note.name == b.name) {
        beacon["used"] = note.used;
        beacon["rejected"] = note.rejected;
        if (note.rms_s) beacon["rms_s"] = *note.rms_s;
      }
    beacons.push_back(std::move(beacon));
  }
  return beacons;
}

struct StopCounts {
  std::size_t used = 0, rejected = 0;
  double squares = 0.0;
};

/// Poses and residuals of the stops of a trajectory.
void add_stops_json(const Trajectory& t, const SharedState& state, Json& stops) {
  std::vector<StopCounts> counts(t.nodes.size());
  for (const ArrivalObservation& a : t.arrivals) {
    StopCounts& count = counts[a.node];
    if (a.rejection != Rejection::kUsed) {
      ++count.rejected;
      continue;
    }
    ++count.used;
    count.squares += std::pow(arrival_residual(t, a, state), 2);
  }
  const std::size_t first = t.nodes.size() - std::min(t.nodes.size(), kMostShownStops);
  for (std::size_t n = first; n < t.nodes.size(); ++n) {
    const Node& node = t.nodes[n];
    if (!node.placed) continue;
    const StopCounts& count = counts[n];
    const Eigen::Vector3d& p = node.T_map_vehicle.translation_m;
    stops.push_back(
        {{"epoch", node.epoch},
         {"x_m", p.x()},
         {"y_m", p.y()},
         {"heading_rad", node.T_map_vehicle.heading_rad()},
         {"used", count.used},
         {"rejected", count.rejected},
         {"rms_sigmas", count.used > 0 ? std::sqrt(count.squares / static_cast<double>(count.used)) : 0.0}});
  }
}

Json findings_json(const Calibration& c) {
  Json findings = Json::array();
  for (const Contradiction& f : c.solution.contradictions)
    findings.push_back({{"kind", to_string(f.kind)},
                        {"subject", f.subject},
                        {"text", in_words(f)},
                        {"remedy", f.remedy},
                        {"exchange", exchange_of(f, c.problem.site)}});
  return findings;
}

Json view_json(const Calibration& c, const survey::ReportInput& input, const Session& session) {
  const calib::Solution& s = c.solution;
  const Deployment& d = input.plan.deployment;
  Json stops = Json::array(), tracks = Json::array();
  for (const Trajectory& t : s.trajectories)
    if (!t.moving) add_stops_json(t, s.state, stops);
  for (const survey::Track& track : input.plan.tracks) {
    if (!track.moving) continue;
    Json points = Json::array();
    for (const Eigen::Vector3d& p : track.points_m) points.push_back({p.x(), p.y()});
    tracks.push_back(std::move(points));
  }
  return {{"verdict", verdict_json(input)},
          {"status", to_string(s.status)},
          {"arrivals", s.statistics.arrivals},
          {"rejected", s.statistics.rejected},
          {"rms_s", s.statistics.rms_s},
          {"variance_factor", s.statistics.variance_factor},
          {"speed_mps", c.deployment ? Json(d.speed_mps(d.medium.temperature_degC)) : Json(nullptr)},
          {"speed_sigma_mps", d.speed_sigma_mps},
          {"datum", s.datum.description},
          {"beacons", beacon_views_json(input)},
          {"stops", stops},
          {"tracks", tracks},
          {"findings", findings_json(c)},
          {"warnings", session.warnings()}};
}

/// A scene without a floor gets the hull of the beacons and the stops, so that the map shows where stops are
/// missing.
Scene with_floor(Scene scene, const Site& site, const Deployment& deployment) {
  if (!scene.floor_m.empty()) return scene;
  std::vector<Eigen::Vector2d> points = deployment.validity_area_m;
  for (std::size_t b = 0; b < deployment.beacons.size(); ++b) {
    const DeploymentBeacon& beacon = deployment.beacons[b];
    if (beacon.status != BeaconStatus::kUndetermined)
      points.emplace_back(beacon.position_m.head<2>());
    else if (const auto place = site.beacons[b].place_m())
      points.emplace_back(place->head<2>());
  }
  scene.floor_m = convex_hull(std::move(points));
  return scene;
}

}  // namespace

std::string floor_json(survey::SurveyModel model, Scene scene, const Deployment* deployment, int threads) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(INFINITY), high = -low;
  for (const Eigen::Vector2d& p : model.floor_m) low = low.cwiseMin(p), high = high.cwiseMax(p);
  scene.cell_m = std::max(0.02, std::sqrt((high - low).prod() / kMostFloorCells));
  scene.headings = 1;
  scene.routes.clear();
  const auto survey =
      survey::run_survey(model, scene, deployment, {.threads = threads, .failures = 0, .integrity = false});
  const survey::FloorMap* map = nullptr;
  if (survey) map = survey->find(survey->calibrated ? "total_m" : "sigma_m");
  if (map == nullptr) return {};
  const survey::FloorGrid& grid = survey->grid;
  Json cells = Json::array(), values = Json::array();
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    cells.push_back(grid.cells[i]);
    const double value_m = map->values[i];
    values.push_back(std::isfinite(value_m) ? Json(std::round(value_m * 1e4) / 1e4) : Json(nullptr));
  }
  return dump({{"origin_m", {grid.origin_m.x(), grid.origin_m.y()}},
               {"cell_m", grid.cell_m},
               {"columns", grid.columns},
               {"rows", grid.rows},
               {"limit_m", map->limit ? Json(*map->limit) : Json(nullptr)},
               {"covered_fraction", survey->covered_fraction},
               {"cells", cells},
               {"values_m", values}});
}

CalibrationView calibration_view(const std::string& site, const std::string& run, const Session& session) {
  CalibrationView view;
  Session quiet = session.part(1);
  try {
    const SurveyInput input = read_survey_input(site, "", "", {}, quiet, BeaconPlaces::kRecorded);
    std::optional<Calibration> calibration;
    try {
      calibration = calibrate_files(site, {run}, {.memory_mb = kViewMemory_mb}, quiet);
    } catch (const CommandFailed& failed) {
      view.message = failed.failure.message;
    }
    if (calibration) {
      const survey::ReportInput report = calibration_report(*calibration, {}, quiet);
      view.calibration = view_json(*calibration, report, quiet);
      if (calibration->deployment) view.deployment = std::make_shared<Deployment>(*calibration->deployment);
    }
    view.next_stop = next_stop_json(input, calibration ? &*calibration : nullptr, quiet);
    view.scene = view.deployment ? with_floor(input.scene, *input.site, *view.deployment) : input.scene;
    auto model = view.deployment ? survey::make_survey_model(*view.deployment, view.scene)
                                 : survey::make_survey_model(*input.site, view.scene);
    if (model) view.model = std::move(*model);
    if (view.model && view.deployment)
      view.floor = floor_json(*view.model, view.scene, view.deployment.get(), 1);
  } catch (const CommandFailed& failed) {
    view.message = failed.failure.message;
  } catch (const std::exception& fault) {
    view.message = std::string("The calibration failed: ") + fault.what();
  }
  return view;
}

Json finish_commissioning(const std::string& site, const std::string& run, bool accept,
                          const Session& session) {
  Session quiet = session.part(session.options.threads);
  try {
    const std::string deployment = run + "/deployment.json";
    ReportArgs report;
    report.paths = {run + "/report.html"};
    const Calibration calibration = calibrate_files(site, {run}, {.accept = accept}, quiet);
    const survey::ReportInput input = calibration_report(calibration, report, quiet);
    need(io::write_file(run + "/site.yaml", need(io::read_file(site))));
    write_calibration(deployment, report, calibration, input);
    const auto failure = failure_of(calibration);
    return {{"status", failure ? failure->status : "ok"},
            {"message", failure ? failure->words() : ""},
            {"exit", static_cast<int>(failure ? failure->exit : kDone)},
            {"run", run},
            {"deployment", calibration.exported() ? Json(deployment) : Json(nullptr)},
            {"report", report.paths.front()},
            {"verdict", verdict_json(input)}};
  } catch (const CommandFailed& failed) {
    return {{"status", failed.failure.status},
            {"message", failed.failure.words()},
            {"exit", static_cast<int>(failed.failure.exit)},
            {"run", run},
            {"deployment", nullptr},
            {"report", nullptr},
            {"verdict", nullptr}};
  }
}

}  // namespace octant::app
