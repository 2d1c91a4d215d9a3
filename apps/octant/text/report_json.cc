// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/report_json.h"

#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/deployment/deployment_json.h"
#include "io/text/json_values.h"

namespace octant {

NLOHMANN_JSON_SERIALIZE_ENUM(ChangeKind, {{ChangeKind::kBeaconMoved, "beacon_moved"},
                                          {ChangeKind::kDelay, "delay"},
                                          {ChangeKind::kReceiver, "receiver"},
                                          {ChangeKind::kSpeed, "speed"},
                                          {ChangeKind::kExchanged, "exchanged"},
                                          {ChangeKind::kDatum, "datum"},
                                          {ChangeKind::kAmplitude, "amplitude"}})
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Change, kind, subject, size, sigma, p)

}  // namespace octant

namespace octant::survey {

using nlohmann::json;

NLOHMANN_JSON_SERIALIZE_ENUM(Outcome, {{Outcome::kCalibrated, "calibrated"},
                                       {Outcome::kRefused, "refused"},
                                       {Outcome::kNotConverged, "not_converged"}})
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Track, moving, points_m, thinned_from)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(WeakNote, description, remedy, consequence_m, blocking,
                                                lone_beacon)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StopNote, name, moving, at_m, used, late, early, other, looked_at, mean_s,
                                   rms_s)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PlanMiss, beacon, at_m, late, early, other)
NLOHMANN_JSON_SERIALIZE_ENUM(LeftOutCause, {{LeftOutCause::kOther, "other"},
                                            {LeftOutCause::kLate, "late"},
                                            {LeftOutCause::kEarly, "early"},
                                            {LeftOutCause::kNoPose, "no_pose"}})
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(LeftOutNote, reason, count, cause)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MovedNote, beacon, shift_m, sigma_m, stated_sigma_m, distance_m)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(BeaconNote, name, used, rejected, redundancy, rms_s, variance_factor,
                                   mdb_s, influence_m, lateness_mdb_s, lateness_influence_m)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ResidualBin, name, from, to, count, mean_s, rms_s)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ResidualChart, by, unit, bins)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Histogram, from, width, counts)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Gate, name, limit, value, pass)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(ErrorFigures, mean_m, rmse_m, ce50_m, ce95_m, ve95_m, se95_m)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(RunFigures, name, fixes, no_fix, matched, errors,
                                                availability, coverage)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LatencyFigures, mean_s, p95_s, largest_s)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Evaluation, fixes, no_fix, matched, position_rmse_m,
                                                position_p95_m, max_error_m, error_quantiles_m,
                                                heading_rmse_rad, nees_mean, errors, availability, coverage,
                                                latency, runs, floors, gates)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(BeaconChange, name, shift_m, sigma_m, p, delay_change_s,
                                                delay_sigma_s, delay_p, significant, delay_significant,
                                                by_datum)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Changes, since, same_datum, beacons, gone, added, found,
                                                limit_p, doubted_control_points, speed_change_mps,
                                                speed_sigma_mps)

/// Cells without a value are NaN in memory and null in JSON.
void to_json(json& j, const NamedMap& map) {
  j = {{"name", map.name},           {"unit", map.unit},
       {"corner_m", map.corner_m},   {"cell_m", map.cell_m},
       {"columns", map.columns},     {"values", map.values},
       {"tolerance", map.tolerance}, {"silent_beacon", map.silent_beacon}};
}
void from_json(const json& j, NamedMap& map) {
  map.name = j.at("name");
  map.unit = j.at("unit");
  map.corner_m = j.at("corner_m").get<Eigen::Vector2d>();
  map.cell_m = j.at("cell_m");
  map.columns = j.at("columns");
  map.silent_beacon = j.at("silent_beacon");
  if (j.contains("tolerance")) j.at("tolerance").get_to(map.tolerance);  // missing in earlier files
  for (const auto& value : j.at("values"))
    map.values.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>());
}

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(BeaconLoss, beacon, covered_fraction, median, p95, map)

/// All fields except the deployment, which has its own format: key(name, value) for each.
template <class Input, class Key>
void for_each_key(Input& r, const Key& key) {
  key("kind", r.kind), key("outcome", r.outcome), key("message", r.message);
  key("tracks", r.plan.tracks), key("fixes_m", r.plan.fixes_m), key("maps", r.plan.maps);
  key("beacons", r.beacons), key("moved", r.moved), key("weak", r.weak), key("left_out", r.left_out);
  key("stops", r.stops), key("misses", r.misses), key("residuals", r.residuals);
  key("standardised", r.standardised), key("looked_at", r.looked_at), key("evaluation", r.evaluation);
  key("no_loss", r.no_loss), key("losses", r.losses);
  key("loss_name", r.loss_name), key("loss_unit", r.loss_unit), key("changes", r.changes);
  key("warnings", r.warnings), key("command", r.command), key("options", r.options);
}

void to_json(json& j, const ReportInput& r) {
  for_each_key(r, [&j](const char* name, const auto& value) { j[name] = value; });
}

void from_json(const json& j, ReportInput& r) {
  for_each_key(r, [&j](const std::string& name, auto& value) {
    const bool newer = name == "moved" || name == "stops" || name == "misses";  // missing in earlier files
    if (!newer || j.contains(name)) j.at(name).get_to(value);
  });
}

}  // namespace octant::survey

namespace octant::app {
namespace {

using nlohmann::json;

constexpr auto kReplace = json::error_handler_t::replace;

}  // namespace

std::string report_to_json(const survey::ReportInput& input) {
  json j = input;
  j["type"] = "octant_report";
  j["version"] = 1;
  j["deployment"] = json::parse(io::deployment_to_json(input.plan.deployment));
  return j.dump(-1, ' ', false, kReplace) + "\n";
}

bool is_saved_report(const std::string& text) {
  const json j = json::parse(text, nullptr, false);
  return j.is_object() && j.contains("type") && j["type"] == "octant_report";
}

Result<survey::ReportInput> report_from_json(const std::string& text, const std::string& file) {
  try {
    const json j = json::parse(text);
    if (j.at("version") != 1) {
      return fail({.code = Errc::kBadInput,
                   .file = file,
                   .found = fmt::format("version {}", j.at("version").dump()),
                   .expected = "1",
                   .advice = "make the report with the octant that saved it, or from the deployment file"});
    }
    auto input = j.get<survey::ReportInput>();
    auto deployment = io::deployment_from_json(j.at("deployment").dump(-1, ' ', false, kReplace), file);
    if (!deployment) return fail(deployment.error());
    input.plan.deployment = std::move(*deployment);
    return input;
  } catch (const json::exception& e) {
    return fail({.code = Errc::kBadInput,
                 .file = file,
                 .found = std::string("this is no saved report: ") + e.what(),
                 .expected = "a file that octant wrote with --report R.json",
                 .advice = "save it again, or name the deployment file"});
  }
}

}  // namespace octant::app
