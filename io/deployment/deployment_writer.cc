// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/deployment/deployment_digest.h"
#include "io/deployment/deployment_json.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"
#include "io/text/json_reader.h"
#include "io/text/json_values.h"
#include "models/support/utc_time.h"
#include "models/validity.h"

namespace octant::io {
namespace {

using Json = nlohmann::ordered_json;

Json medium_json(const Deployment& d) {
  Json json = {{"model", std::string(to_string(d.medium.model))},
               {"speed_mps", d.speed_mps(d.medium.temperature_degC)},
               {"sigma_mps", d.speed_sigma_mps},
               {"reference_temperature_degC", d.medium.temperature_degC},
               {"relative_humidity", d.medium.relative_humidity},
               {"pressure_pa", d.medium.pressure_pa},
               {"constant_speed_mps", d.medium.speed_mps},
               {"offset_mps", d.speed_offset_mps}};
  if (d.medium.profile) {
    Json levels = Json::array();
    for (const SpeedProfile::Level& level : d.medium.profile->levels())
      levels.push_back({level.height_m, level.speed_mps});
    json["profile"] = std::move(levels);
  }
  return json;
}

Json timing_json(const Timing& t) {
  Json per = Json::array();
  if (t.delay_per.beacon) per.push_back("beacon");
  if (t.delay_per.receiver) per.push_back("receiver");
  if (t.delay_per.site) per.push_back("site");
  if (per.size() < 2) per = per.empty() ? Json("none") : Json(per[0]);
  return {{"clock", t.clock == Clock::kCycleOffset ? "cycle_offset" : "synchronised"},
          {"ranging", t.ranging == Ranging::kTwoWay ? "two_way" : "one_way"},
          {"turnaround_s", t.turnaround_s},
          {"delay_per", per},
          {"delay_s", t.delay_s},
          {"delay_sigma_s", t.delay_sigma_s},
          {"drift_ppm", 1e6 * t.drift},
          {"drift_sigma_ppm", 1e6 * t.drift_sigma}};
}

Json noise_json(const Noise& n, const CorrelatedNoise& correlated) {
  Json json = {{"tof_sigma_s", n.tof_sigma_s},
               {"amplitude_relative_sigma", n.amplitude_relative_sigma},
               {"pair_sigma_s", n.pair_sigma_s},
               {"bearing_sigma_rad", n.bearing_sigma_rad},
               {"range_sigma_m", n.range_sigma_m}};
  if (correlated.any()) {
    json["correlated"] = {{"sigma_s", correlated.sigma_s},
                          {"time_s", correlated.time_s},
                          {"pair_sigma_s", correlated.pair_sigma_s}};
  }
  return json;
}

Json attenuation_json(const std::optional<AttenuationModel>& a) {
  if (!a) return nullptr;
  return {{"amplitude_1m_v", a->amplitude_1m_v},
          {"absorption_np_per_m", a->absorption_np_per_m},
          {"threshold_v", a->threshold_v},
          {"rise_time_s", a->rise_time_s},
          {"half_power_angle_rad", a->directional() ? Json(a->half_power_angle_rad) : Json(nullptr)},
          {"saturation_v", std::isfinite(a->saturation_v) ? Json(a->saturation_v) : Json(nullptr)}};
}

Json beacons_json(const Deployment& d) {
  Json out = Json::array();
  for (const DeploymentBeacon& b : d.beacons) {
    Json covariance = Json::array();
    for (int i = 0; i < 3; ++i) covariance.push_back(Eigen::Vector3d(b.covariance_m2.row(i)));
    out.push_back({{"id", b.name},
                   {"position_m", b.position_m},
                   {"covariance_m2", covariance},
                   {"delay_s", b.delay_s},
                   {"delay_sigma_s", b.delay_sigma_s},
                   {"status", to_string(b.status)}});
    if (b.gain != 1.0) out.back()["gain"] = b.gain;  // absent else: older files keep their digest
  }
  return out;
}

Json rail_json(const Rail& rail) {
  if (rail.shape == Rail::Shape::kArc) return {{"centre_m", rail.centre_m}, {"radius_m", rail.radius_m}};
  return {{"from_m", rail.from_m}, {"to_m", rail.to_m}};
}

Json vehicles_json(const Deployment& d) {
  Json out = Json::array();
  for (const SiteVehicle& vehicle : d.vehicles) {
    Json receivers = Json::array();
    for (std::size_t i = 0; i < vehicle.receiver_count; ++i) {
      const DeploymentReceiver& r = d.receivers[vehicle.first_receiver + i];
      receivers.push_back({{"id", r.name},
                           {"position_m", r.position_m},
                           {"sigma_m", r.sigma_m},
                           {"delay_s", r.delay_s},
                           {"delay_sigma_s", r.delay_sigma_s},
                           {"axis", r.axis},
                           {"hearing_cosine", r.hearing_cosine}});
    }
    Json json = {{"id", vehicle.name}, {"receivers", receivers}};
    if (d.timing.clock == Clock::kCycleOffset) {
      json["clock_drift_ppm"] = 1e6 * vehicle.clock_drift;
      json["clock_drift_sigma_ppm"] = 1e6 * vehicle.clock_drift_sigma;
    }
    if (const auto& m = vehicle.motion)
      json["motion"] = {{"speed_mps", m->speed_mps},
                        {"acceleration_mps2", m->acceleration_mps2},
                        {"turn_rate_rad_per_s", m->turn_rate_rad_per_s},
                        {"turn_acceleration_rad_per_s2", m->turn_acceleration_rad_per_s2}};
    if (vehicle.rail)
      json["rail"] = rail_json(*vehicle.rail);  // absent where there is none: older files keep their digest
    out.push_back(std::move(json));
  }
  return out;
}

Json covariance_json(const JointCovariance& c, const NameTable& names) {
  Json triangle = Json::array();
  for (Eigen::Index i = 0; i < c.matrix.rows(); ++i) {
    for (Eigen::Index j = i; j < c.matrix.cols(); ++j) triangle.push_back(c.matrix(i, j));
  }
  return {{"parameters", parameter_names(c.parameters, names)}, {"upper_triangle", triangle}};
}

Json statistics_json(const CalibrationStatistics& s) {
  return {{"arrivals", s.arrivals},
          {"rejected", s.rejected},
          {"unknowns", s.unknowns},
          {"redundancy", s.redundancy},
          {"variance_factor", s.variance_factor},
          {"chi2_p", s.chi2_p},
          {"rms_s", s.rms_s},
          {"converged", s.converged}};
}

Json validity_json(const Deployment& d) {
  Json json = {{"temperature_degC", d.validity_temperature_degC}, {"area", d.validity_area_m}};
  if (d.validity_heights_m) json["heights_m"] = *d.validity_heights_m;
  if (d.validity_reach_m)
    json["reach_m"] = *d.validity_reach_m;  // absent where there is none: older files keep their digest
  if (!d.validity_period.stated())
    return json;  // absent where nothing is stated: older files keep their digest
  json["months"] = d.validity_period.months;
  json["beacon_drift_m_per_month"] = d.validity_period.beacon_drift_m_per_month;
  const auto due = calibration_due(d);
  json["until"] = due ? Json(utc_text(due->at_s)) : Json(nullptr);
  return json;
}

Json previous_json(const Previous& p, const NameTable& names) {
  std::vector<std::string> released = parameter_names(p.released.parameters, names);
  if (p.released.datum) released.emplace_back("datum");
  return {{"sha256", p.sha256},
          {"created", p.created},
          {"drift",
           {{"beacon_m", p.drift.beacon_m},
            {"delay_s", p.drift.delay_s},
            {"receiver_m", p.drift.receiver_m},
            {"speed_mps", p.drift.speed_mps},
            {"log_gain", p.drift.log_gain},
            {"attenuation", p.drift.attenuation}}},
          {"released", released},
          {"changes", json_of(p.changes)}};
}

Json content_of(const Deployment& d) {
  Json json = {{"type", "octant_deployment"},
               {"version", 1},
               {"site", d.site},
               {"created", d.created},
               {"motion", d.motion == Motion::kSpatial ? "spatial" : "planar"}};
  json["datum"] = {{"description", d.datum.description},
                   {"position", d.datum.position},
                   {"orientation", d.datum.orientation},
                   {"scale", d.datum.scale},
                   {"control_points", d.datum.control_points}};
  json["medium"] = medium_json(d);
  json["timing"] = timing_json(d.timing);
  json["noise"] = noise_json(d.noise, d.correlated_noise);
  json["attenuation"] = attenuation_json(d.attenuation);
  json["beacons"] = beacons_json(d);
  json["vehicles"] = vehicles_json(d);
  json["statistics"] = statistics_json(d.statistics);
  json["tolerance"] = {{"beacon_m", d.tolerance.beacon_m}, {"fix_m", d.tolerance.fix_m}};
  json["validity"] = validity_json(d);
  // Left out without values, so that older digests remain valid.
  if (const DriftRates& drift = d.drift; drift.given())
    json["drift"] = {{"beacon_m_per_year", drift.beacon_m_per_year},
                     {"delay_m_per_year", drift.delay_m_per_year},
                     {"receiver_m_per_year", drift.receiver_m_per_year},
                     {"speed_mps_per_year", drift.speed_mps_per_year}};
  json["inputs"] = Json::array();
  for (const InputDigest& input : d.inputs)
    json["inputs"].push_back({{"path", input.path}, {"sha256", input.sha256}});
  json["program"] = {{"name", "octant"}, {"version", d.program_version}, {"command", d.program_command}};
  json["warnings"] = d.warnings;
  if (d.previous) json["previous"] = previous_json(*d.previous, names_of(d));
  if (!d.contradictions.empty())
    json["verdict"] = {{"grade", "Contradicted"}, {"contradictions", json_of(d.contradictions)}};
  json["covariance"] = covariance_json(d.covariance, names_of(d));
  return json;
}

/// Pointer to the first number that is not finite; empty if all are.
std::string find_not_finite(const Json& json, const std::string& pointer) {
  if (json.is_number_float()) return std::isfinite(json.get<double>()) ? "" : pointer;
  if (!json.is_structured()) return "";
  std::size_t index = 0;
  for (const auto& [key, value] : json.items()) {
    // The pointer is computed for containers only, because most values are numbers of a long array.
    if (value.is_number_float() && std::isfinite(value.template get<double>())) {
      ++index;
      continue;
    }
    std::string found =
        find_not_finite(value, pointer + "/" + (json.is_array() ? std::to_string(index) : key));
    if (!found.empty()) return found;
    ++index;
  }
  return "";
}

std::string text_of(Json json) {
  json["digest"] = digest_of(nlohmann::json(json));
  return pretty(json);
}

}  // namespace

std::string deployment_to_json(const Deployment& deployment) { return text_of(content_of(deployment)); }

Result<std::string> checked_deployment_json(const std::string& path, const Deployment& deployment) {
  constexpr const char* kReport = "this is a fault of the program: please report it";
  const Json json = content_of(deployment);
  if (const std::string pointer = find_not_finite(json, ""); !pointer.empty()) {
    return fail({.code = Errc::kOutput,
                 .file = path,
                 .found = fmt::format("not written: {} is not a finite number", pointer),
                 .advice = kReport});
  }
  std::string text = text_of(json);
  if (const auto read = deployment_from_json(text, path); !read)
    return fail({.code = Errc::kOutput,
                 .file = path,
                 .found = fmt::format("not written: it cannot be read back ({})", read.error().found),
                 .expected = read.error().expected,
                 .advice = kReport});
  return text;
}

Result<void> write_deployment(const std::string& path, const Deployment& deployment) {
  return checked_deployment_json(path, deployment).and_then([&path](const std::string& text) {
    return write_file(path, text);
  });
}

}  // namespace octant::io
