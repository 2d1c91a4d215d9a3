// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/stop_plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/octant/steps/next_stops.h"
#include "calib/plan/stations.h"
#include "survey/report/report_sections.h"
#include "survey/schedule/stop_places.h"

namespace octant::app {
namespace {

constexpr int kPlannedStops = 3;
constexpr double kStopClearance_m = 0.5;
constexpr int kMostNeeded = 99;  ///< larger estimates say only that the tolerance is far away
/// Longer half axis of the 95 % ellipse of a circular error, relative to the root of the sum of its two
/// variances: sqrt(5.99 / 2).
constexpr double kCircular95 = 1.73;

/// Firings of each beacon at the stops so far: arrivals of a stop over its pairs of beacon and receiver.
int firings_at_stops(const calib::Solution& solution) {
  std::size_t arrivals = 0, pairs = 0;
  for (const Trajectory& t : solution.trajectories) {
    if (t.moving) continue;
    std::set<std::pair<std::size_t, std::size_t>> met;
    std::uint32_t node = 0;
    for (const ArrivalObservation& a : t.arrivals) {
      if (a.node != node) pairs += met.size(), met.clear();
      node = a.node;
      met.emplace(a.beacon.index(), a.receiver.index());
      ++arrivals;
    }
    pairs += met.size();
  }
  return pairs == 0 ? 1 : std::max(1, static_cast<int>(std::lround(arrivals / static_cast<double>(pairs))));
}

/// Stops until all beacons meet the tolerance. The plan predicts sigmas for its own stops; beyond them the
/// information of the worst beacon is assumed to grow at the same rate.
std::optional<int> stops_needed(const calib::StationPlan& plan, const calib::Knowledge& knowledge,
                                const Deployment* deployment, double tolerance_m) {
  const auto worst_m = [&](const calib::BeaconKnowledge& k) {
    double worst = 0.0;
    for (std::size_t b = 0; b < k.sigma_m.size(); ++b) {
      double radius = kCircular95;
      if (deployment != nullptr && deployment->beacons[b].covariance_m2.trace() > 0)
        radius = survey::radius95_m(deployment->beacons[b]) /
                 std::sqrt(deployment->beacons[b].covariance_m2.trace());
      worst = std::max(worst, knowledge.placed[b] ? radius * k.sigma_m[b] : INFINITY);
    }
    return worst;
  };
  if (worst_m(plan.before) <= tolerance_m) return 0;
  for (std::size_t i = 0; i < plan.stations.size(); ++i)
    if (worst_m(plan.stations[i].after) <= tolerance_m) return static_cast<int>(i + 1);
  const double before = std::pow(worst_m(plan.before), -2), after = std::pow(worst_m(plan.after), -2);
  const double growth = (after - before) / static_cast<double>(plan.stations.size());
  if (!(growth > 0)) return std::nullopt;
  return std::min(kMostNeeded, static_cast<int>(std::ceil((std::pow(tolerance_m, -2) - before) / growth)));
}

Json stop_plan_json(const calib::StationPlan& plan, const SurveyInput& input, std::optional<int> needed) {
  const calib::Station& s = plan.stations.front();
  const std::vector<std::string> names = input.names().beacons;
  Json further = Json::array(), heard = Json::array();
  for (std::size_t i = 1; i < plan.stations.size(); ++i)
    further.push_back({plan.stations[i].position_m.x(), plan.stations[i].position_m.y()});
  for (std::size_t b = 0; b < names.size(); ++b)
    if (s.arrivals[b] > 0) heard.push_back(names[b]);
  return {{"x_m", s.position_m.x()},
          {"y_m", s.position_m.y()},
          {"heading_rad", s.heading_rad},
          {"beacons", heard},
          {"most_for", names[s.most_improved]},
          {"sigma_before_m", s.improved_from_m},
          {"sigma_after_m", s.improved_to_m},
          {"further", further},
          {"stops_needed", needed ? Json(*needed) : Json(nullptr)}};
}

/// Beacons and speed as calibrated so far, or as in the site file before the first calibration.
Result<KnownBefore> known_before_stop(const Site& site, const Calibration* calibration) {
  if (calibration != nullptr)
    if (auto known = known_from(*calibration, 1)) return known;
  auto knowledge = calib::knowledge_of(site);
  if (!knowledge) return fail(knowledge.error());
  return KnownBefore{std::move(*knowledge), {}, {}};
}

}  // namespace

Json next_stop_json(const SurveyInput& given, const Calibration* calibration, Session& session) {
  SurveyInput input = given;
  auto known = known_before_stop(*input.site, calibration);
  const bool all_fixed =
      std::ranges::all_of(input.site->beacons, [](const SiteBeacon& b) { return b.is_control_point(); });
  if (!known || all_fixed || std::ranges::count(known->knowledge.placed, true) == 0) return nullptr;
  try {
    place_recorded(input.site->path, known->knowledge.placed, known->knowledge.state.beacon_p_map_m, input,
                   session);
  } catch (const CommandFailed&) {
    return nullptr;
  }
  const auto places = survey::stop_places(input.model, input.scene, 0.0, kStopClearance_m);
  if (!places) return nullptr;
  known->hearing.range_m = std::min(known->hearing.range_m, survey::reach_m(input.model.hearing));
  restrict_by_scene(input, input.model, known->hearing);
  calib::StationOptions options;
  options.stations = kPlannedStops;
  options.headings = 4;
  options.sweeps = 1;
  options.stop = {.hearing = known->hearing,
                  .vehicle = VehicleId(input.model.vehicle),
                  .firings = calibration != nullptr ? firings_at_stops(calibration->solution) : 1,
                  .height_m = input.model.vehicle_z_m,
                  .measured_poses = known->measured_poses};
  options.places_m = places->places_m;
  options.spacing_m = places->spacing_m;
  options.may_stop = places->may_stop;
  const auto plan = calib::plan_stations(known->knowledge, options);
  if (!plan || plan->stations.empty()) return nullptr;
  const auto& tolerance_m = input.site->tolerance.beacon_m;
  const Deployment* deployment =
      calibration != nullptr && calibration->deployment ? &*calibration->deployment : nullptr;
  return stop_plan_json(
      *plan, input,
      tolerance_m ? stops_needed(*plan, known->knowledge, deployment, *tolerance_m) : std::nullopt);
}

Json exchange_of(const Contradiction& contradiction, const Site& site) {
  if (contradiction.kind != ContradictionKind::kExchanged) return nullptr;
  for (const SiteBeacon& a : site.beacons)
    for (const SiteBeacon& b : site.beacons)
      if (contradiction.subject == a.name + ", " + b.name) return {a.name, b.name};
  return nullptr;
}

}  // namespace octant::app
