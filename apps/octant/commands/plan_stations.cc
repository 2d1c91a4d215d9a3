// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/octant/commands/plan.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/progress.h"
#include "apps/octant/steps/next_stops.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/survey_input.h"
#include "apps/octant/text/layout.h"
#include "calib/plan/stations.h"
#include "io/text/atomic_file.h"
#include "io/text/text.h"
#include "survey/schedule/stop_places.h"

namespace octant::app {
namespace {

constexpr double kDegrees = 180 / M_PI;

/// Calibrates the existing recordings, from which the prior information and the reception follow.
KnownBefore known_from_runs(const PlanArgs& args, const Site& site, Session& session) {
  ProgressReporter reporter(progress_style(session.options.progress, session.options.quiet));
  calib::CalibrationOptions options;
  options.solve = solve_options(session, reporter, 0.5);
  options.on_finding = [&session](const calib::Finding& f) { session.warn(f.text); };
  const calib::Calibration calibration =
      need(calib::calibrate(site, read_runs(args.runs, site, {}, session), options));
  const calib::Solution& solution = calibration.solution;
  stop_if_interrupted(solution.status == calib::SolveStatus::kInterrupted);
  if (!calibration.deployment)
    session.warn("the recordings alone would not be exported: " + solution.message);
  for (const Contradiction& c : solution.contradictions)
    session.warn(fmt::format("The recordings contradict what was stated: {}; {}", in_words(c), c.remedy));
  return need(known_from(calibration, session.threads()));
}

KnownBefore known_before(const PlanArgs& args, const SurveyInput& input, Session& session) {
  if (!args.runs.empty() && !input.site)
    fail_with({.code = Errc::kUsage,
               .file = args.input,
               .found = "recordings beside a deployment",
               .expected = "a site file with recordings, or a deployment alone"});
  if (!args.runs.empty()) return known_from_runs(args, *input.site, session);
  return {need(input.site ? calib::knowledge_of(*input.site) : calib::knowledge_of(*input.deployment),
               args.input),
          {},
          {}};
}

/// Range and angle from the arguments, else from the recordings; walls and beam patterns from the scene, for
/// the beacons of the model.
void complete_hearing(const PlanArgs& args, const SurveyInput& input, survey::SurveyModel& model,
                      KnownBefore& before) {
  calib::HearingModel& hearing = before.hearing;
  hearing.range_m = args.range_m.value_or(std::min(hearing.range_m, survey::reach_m(model.hearing)));
  if (args.hearing_deg) hearing.half_angle_rad = *args.hearing_deg / kDegrees;
  if (args.range_m) model.hearing.range_m = *args.range_m;
  restrict_by_scene(input, model, hearing);
}

Json known_json(const calib::BeaconKnowledge& k, const std::vector<std::string>& names) {
  return {{"mean_sigma_m", k.mean_m},
          {"worst_sigma_m", k.worst_m},
          {"worst_beacon", names.empty() ? Json(nullptr) : Json(names[k.worst_beacon])}};
}

/// Fails if no beacon's position is unknown, because no stop could improve any.
void check_something_is_asked_for(const PlanArgs& args, const SurveyInput& input) {
  bool all_held = true;
  std::size_t beacons = 0;
  if (input.site) {
    for (const SiteBeacon& b : input.site->beacons) all_held = all_held && b.is_control_point();
    beacons = input.site->beacons.size();
  } else {
    for (const DeploymentBeacon& b : input.deployment->beacons)
      all_held = all_held && b.status == BeaconStatus::kControlPoint;
    beacons = input.deployment->beacons.size();
  }
  if (!all_held) return;
  fail_with({.file = args.input,
             .found = fmt::format("all {} beacons are control points (sigma_m: 0): their positions are held, "
                                  "and no stop can tell them better",
                                  beacons),
             .expected = "at least one beacon whose position is to be calibrated",
             .advice = "state how far off their positions may be as sigma_m; where they are exact, nothing "
                       "but delays and the speed is left, and stops anywhere among the beacons tell those"});
}

std::string heard_words(const calib::Station& s, const std::vector<std::string>& names) {
  std::string heard;
  for (std::size_t b = 0; b < names.size(); ++b)
    if (s.arrivals[b] > 0) heard += (heard.empty() ? "" : " ") + names[b];
  return heard;
}

Json stations_plan_json(const PlanArgs& args, const calib::StationPlan& plan,
                        const std::vector<std::string>& names, double random_mean_m, const Session& session) {
  Json stations = Json::array(), beacons = Json::array();
  for (std::size_t i = 0; i < plan.stations.size(); ++i) {
    const calib::Station& s = plan.stations[i];
    Json heard = Json::array();
    for (std::size_t b = 0; b < names.size(); ++b)
      if (s.arrivals[b] > 0) heard.push_back(names[b]);
    stations.push_back({{"order", i + 1},
                        {"x_m", s.position_m.x()},
                        {"y_m", s.position_m.y()},
                        {"heading_rad", s.heading_rad},
                        {"beacons", heard},
                        {"arrivals", s.arrival_count},
                        {"most_for", names[s.most_improved]},
                        {"sigma_before_m", s.improved_from_m},
                        {"sigma_after_m", s.improved_to_m},
                        {"mean_sigma_m", s.after.mean_m},
                        {"worst_sigma_m", s.after.worst_m}});
  }
  for (std::size_t b = 0; b < names.size(); ++b)
    beacons.push_back(
        {{"id", names[b]},
         {"sigma_before_m", plan.before.sigma_m[b] < 0 ? Json(nullptr) : Json(plan.before.sigma_m[b])},
         {"sigma_after_m", plan.after.sigma_m[b] < 0 ? Json(nullptr) : Json(plan.after.sigma_m[b])}});
  return {{"plan", "stations"},
          {"criterion", args.criterion},
          {"before", known_json(plan.before, names)},
          {"after", known_json(plan.after, names)},
          {"random_mean_sigma_m", random_mean_m},
          {"stations", stations},
          {"beacons", beacons},
          {"candidates", plan.candidates},
          {"exchanges", plan.exchanges},
          {"seconds", session.seconds()}};
}

std::string plan_csv(const calib::StationPlan& plan, const std::vector<std::string>& names) {
  std::string csv =
      "order,x_m,y_m,heading_rad,heading_deg,arrivals,beacons,most_for,mean_sigma_m,worst_sigma_m\n";
  for (std::size_t i = 0; i < plan.stations.size(); ++i) {
    const calib::Station& s = plan.stations[i];
    csv += fmt::format("{},{:.3f},{:.3f},{:.4f},{:.1f},{},{},{},{:.6g},{:.6g}\n", i + 1, s.position_m.x(),
                       s.position_m.y(), s.heading_rad, s.heading_rad * kDegrees, s.arrival_count,
                       io::csv_field(heard_words(s, names)), io::csv_field(names[s.most_improved]),
                       s.after.mean_m, s.after.worst_m);
  }
  return csv;
}

std::string stations_plan_text(const calib::StationPlan& plan, const std::vector<std::string>& names,
                               double random_mean_m, const std::string& site) {
  std::string text = fmt::format("{}: {} stops, the best first\n\n", site, plan.stations.size());
  Table table{"rrrrrrrrl",
              {{"stop", "x", "y", "heading", "heard", "", "mean", "worst", "most for,"},
               {"", "[m]", "[m]", "[deg]", "arrivals", "beacons", "sigma", "sigma", "known to"}}};
  table.rows.push_back(
      {"", "", "", "", "", "now", length_text(plan.before.mean_m), length_text(plan.before.worst_m), ""});
  for (std::size_t i = 0; i < plan.stations.size(); ++i) {
    const calib::Station& s = plan.stations[i];
    const auto heard = std::ranges::count_if(s.arrivals, [](auto n) { return n > 0; });
    table.rows.push_back({fmt::format("{}", i + 1), fmt::format("{:.2f}", s.position_m.x()),
                          fmt::format("{:.2f}", s.position_m.y()),
                          fmt::format("{:.0f}", s.heading_rad * kDegrees), fmt::format("{}", s.arrival_count),
                          fmt::format("{} of {}", heard, names.size()), length_text(s.after.mean_m),
                          length_text(s.after.worst_m),
                          names[s.most_improved] + " " + length_text(s.improved_to_m)});
  }
  text += table.text() + "\n";
  text += fmt::format("{:<17}mean {} -> {}, worst {} -> {} ({})\n", "predicted sigma",
                      length_text(plan.before.mean_m), length_text(plan.after.mean_m),
                      length_text(plan.before.worst_m), length_text(plan.after.worst_m),
                      names[plan.after.worst_beacon]);
  text += fmt::format("{:<17}mean {} (median of 25 plans with as many stops)\n", "random stops",
                      length_text(random_mean_m));
  return text + fmt::format(
                    "{:<17}sigmas are the root of the sum of a beacon's three variances,\n"
                    "{:<17}as the calibration would state them\n",
                    "", "");
}

}  // namespace

int plan_stations(const PlanArgs& args, Session& session) {
  check_outputs(with_files(args.runs, {args.input, args.scene}), {{"--csv", args.csv}}, session);
  SurveyInput input = read_survey_input(args.input, args.scene, args.vehicle, {}, session,
                                        args.runs.empty() ? BeaconPlaces::kStated : BeaconPlaces::kRecorded);
  check_something_is_asked_for(args, input);
  KnownBefore before = known_before(args, input, session);
  const calib::Knowledge& known = before.knowledge;
  if (!args.runs.empty())
    place_recorded(args.input, known.placed, known.state.beacon_p_map_m, input, session);
  session.warn(known.warnings);
  complete_hearing(args, input, input.model, before);
  const auto places =
      need(survey::stop_places(input.model, input.scene, args.grid_m.value_or(0.0), args.clearance_m));
  ProgressReporter reporter(progress_style(session.options.progress, session.options.quiet));
  calib::StationOptions options;
  options.stations = *args.stations;
  options.headings = args.headings;
  options.criterion = args.criterion == "d" ? calib::StationCriterion::kD : calib::StationCriterion::kA;
  options.stop.hearing = before.hearing;
  options.stop.vehicle = VehicleId(input.model.vehicle);
  options.stop.firings = args.rounds;
  options.stop.height_m = input.model.vehicle_z_m;
  options.stop.measured_poses = before.measured_poses;
  options.places_m = places.places_m;
  options.spacing_m = places.spacing_m;
  options.may_stop = places.may_stop;
  options.threads = session.threads();
  options.on_progress = [&](double fraction) {
    reporter.show("stops", 0, 0.0, args.runs.empty() ? fraction : 0.5 + 0.5 * fraction);
    return !interrupted();
  };
  const calib::StationPlan plan = need(calib::plan_stations(known, options));
  reporter.finish();
  stop_if_interrupted(plan.interrupted);
  const double random_mean_m = calib::random_stations_mean_m(known, options, session.options.seed);
  const std::vector<std::string> names = input.names().beacons;
  Json object = stations_plan_json(args, plan, names, random_mean_m, session);
  if (!args.csv.empty()) need(io::write_file(args.csv, plan_csv(plan, names)));
  session.result(stations_plan_text(plan, names, random_mean_m, input.model.name));
  return session.finish(object);
}

}  // namespace octant::app
