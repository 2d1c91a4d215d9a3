// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <memory>
#include <unordered_set>

#include <fmt/format.h>

#include "io/deployment/deployment_digest.h"
#include "io/deployment/deployment_json.h"
#include "io/text/bounds.h"
#include "io/text/json_reader.h"

namespace octant::io {
namespace {

const std::vector<std::pair<std::string, MediumModel>> kMediumModels = {
    {"cramer1993", MediumModel::kCramer1993},
    {"linear_temperature", MediumModel::kLinearTemperature},
    {"constant", MediumModel::kConstant}};
const std::vector<std::pair<std::string, bool DelayPer::*>> kDelayPer = {{"beacon", &DelayPer::beacon},
                                                                         {"receiver", &DelayPer::receiver},
                                                                         {"site", &DelayPer::site},
                                                                         {"none", nullptr}};

std::optional<double> optional_number(const JsonValue& value, NumberRange range = kAnyNumber) {
  return value.present() ? std::optional<double>(value.number(range)) : std::nullopt;
}

double number_or(const JsonValue& value, double fallback, NumberRange range = kAnyNumber) {
  return optional_number(value, range).value_or(fallback);
}

void read_profile_levels(const JsonValue& json, Medium& medium) {
  if (!json.present()) return;
  std::vector<SpeedProfile::Level> levels;
  for (const JsonValue& item : json.items()) {
    const std::vector<double> level = item.numbers(2);
    if (level.size() != 2 || !(level[1] > 0) || (!levels.empty() && !(level[0] > levels.back().height_m)))
      return item.fail("a level out of order, or a speed that is not positive",
                       "[height_m, speed_mps] from below upwards");
    levels.push_back({level[0], level[1]});
  }
  if (levels.empty()) return json.fail("an empty list", "one level or more");
  medium.profile = std::make_shared<const SpeedProfile>(std::move(levels));
}

void read_deployed_medium(const JsonValue& json, Deployment& d) {
  Medium& m = d.medium;
  m.model = json.at("model").choice(kMediumModels);
  m.temperature_degC = json.at("reference_temperature_degC").number();
  m.relative_humidity = number_or(json.find("relative_humidity"), m.relative_humidity);
  m.pressure_pa = number_or(json.find("pressure_pa"), m.pressure_pa);
  const double calibrated_mps = json.at("speed_mps").number(kPositive);
  m.speed_mps = number_or(json.find("constant_speed_mps"), calibrated_mps);
  read_profile_levels(json.find("profile"), m);
  // Other programs read speed_mps; this one derives it from the model and its offset.
  d.speed_offset_mps = number_or(json.find("offset_mps"), calibrated_mps - speed_mps(m));
  d.speed_sigma_mps = json.at("sigma_mps").number(kNotNegative);
  const double offset_speed_mps = d.speed_mps(m.temperature_degC);
  if (!(std::abs(offset_speed_mps - calibrated_mps) <= 1e-9 * calibrated_mps)) {
    json.at("speed_mps")
        .fail(exact(calibrated_mps),
              fmt::format("{}, the model's speed and offset_mps", exact(offset_speed_mps)));
  }
}

void read_deployed_timing(const JsonValue& json, Timing& t) {
  t.clock = json.at("clock").choice<Clock>(
      {{"synchronised", Clock::kSynchronised}, {"cycle_offset", Clock::kCycleOffset}});
  if (const JsonValue ranging = json.find("ranging"); ranging.present())
    t.ranging = ranging.choice<Ranging>({{"one_way", Ranging::kOneWay}, {"two_way", Ranging::kTwoWay}});
  t.turnaround_s = number_or(json.find("turnaround_s"), 0.0);
  const JsonValue per = json.at("delay_per");
  const std::vector<JsonValue> words = per.is_array() ? per.items() : std::vector<JsonValue>{per};
  for (const JsonValue& word : words)
    if (const auto member = word.choice(kDelayPer); member != nullptr) t.delay_per.*member = true;
  t.delay_s = number_or(json.find("delay_s"), 0.0);
  t.delay_sigma_s = number_or(json.find("delay_sigma_s"), 0.0);
  t.drift = 1e-6 * number_or(json.find("drift_ppm"), 0.0);
  t.drift_sigma = 1e-6 * number_or(json.find("drift_sigma_ppm"), 0.0);
}

void read_deployed_noise(const JsonValue& json, Noise& n) {
  n.tof_sigma_s = json.at("tof_sigma_s").number(kPositive);
  n.amplitude_relative_sigma = number_or(json.find("amplitude_relative_sigma"), n.amplitude_relative_sigma);
  n.pair_sigma_s = optional_number(json.find("pair_sigma_s"));
  n.bearing_sigma_rad = number_or(json.find("bearing_sigma_rad"), n.bearing_sigma_rad);
  n.range_sigma_m = number_or(json.find("range_sigma_m"), n.range_sigma_m);
}

void read_correlated_noise(const JsonValue& json, CorrelatedNoise& c) {
  if (!json.present()) return;
  const auto read = [&json](const char* key) { return number_or(json.find(key), 0.0, kNotNegative); };
  c = {read("sigma_s"), read("time_s"), read("pair_sigma_s")};
}

std::string take_id(const JsonValue& json, std::unordered_set<std::string>& taken) {
  const JsonValue id = json.at("id");
  std::string name = id.text();
  if (name.empty()) id.fail("empty", "a name");
  if (!taken.insert(name).second) id.fail(in_quotes(name) + ", which is used twice", "each id once");
  return name;
}

void read_deployed_beacons(const JsonValue& json, Deployment& d) {
  std::unordered_set<std::string> taken;
  for (const JsonValue& item : json.items()) {
    DeploymentBeacon b;
    b.name = take_id(item, taken);
    b.position_m = item.at("position_m").vector3();
    const JsonValue covariance = item.at("covariance_m2");
    const std::vector<JsonValue> rows = covariance.items();
    if (rows.size() != 3) covariance.fail(fmt::format("an array of {}", rows.size()), "3 rows of 3 numbers");
    for (std::size_t i = 0; i < 3 && i < rows.size(); ++i)
      b.covariance_m2.row(static_cast<Eigen::Index>(i)) = rows[i].vector3();
    if (!(b.covariance_m2.diagonal().minCoeff() >= 0.0))
      covariance.fail("with a negative variance", "a covariance");
    b.delay_s = item.at("delay_s").number();
    b.delay_sigma_s = item.at("delay_sigma_s").number(kNotNegative);
    b.gain = number_or(item.find("gain"), b.gain, kPositive);
    b.status = item.at("status").choice<BeaconStatus>({{"calibrated", BeaconStatus::kCalibrated},
                                                       {"control_point", BeaconStatus::kControlPoint},
                                                       {"undetermined", BeaconStatus::kUndetermined}});
    d.beacons.push_back(std::move(b));
  }
}

Eigen::Vector2d point_of(const JsonValue& json) {
  const std::vector<double> at = json.numbers(2);
  return {at[0], at[1]};
}

std::optional<Rail> read_deployed_rail(const JsonValue& json) {
  if (!json.present()) return std::nullopt;
  Rail rail;
  if (json.find("centre_m").present()) {
    rail.shape = Rail::Shape::kArc;
    rail.centre_m = point_of(json.at("centre_m"));
    rail.radius_m = json.at("radius_m").number(kPositive);
  } else {
    rail.from_m = point_of(json.at("from_m"));
    rail.to_m = point_of(json.at("to_m"));
    if (rail.from_m == rail.to_m) json.at("to_m").fail("where the rail begins", "another point");
  }
  return rail;
}

void read_deployed_vehicles(const JsonValue& json, Deployment& d) {
  std::unordered_set<std::string> taken;
  for (const JsonValue& item : json.items()) {
    const VehicleId vehicle(d.vehicles.size());
    d.vehicles.push_back({take_id(item, taken), d.receivers.size(), 0});
    std::unordered_set<std::string> taken_here;
    for (const JsonValue& entry : item.at("receivers").items()) {
      DeploymentReceiver r;
      r.name = take_id(entry, taken_here);
      r.vehicle = vehicle;
      r.position_m = entry.at("position_m").vector3();
      r.sigma_m = entry.at("sigma_m").vector3();
      r.delay_s = entry.at("delay_s").number();
      r.delay_sigma_s = number_or(entry.find("delay_sigma_s"), 0.0);
      if (const JsonValue axis = entry.find("axis"); axis.present()) r.axis = axis.vector3();
      r.hearing_cosine = optional_number(entry.find("hearing_cosine"));
      d.receivers.push_back(std::move(r));
    }
    SiteVehicle& read = d.vehicles.back();
    read.receiver_count = d.receivers.size() - read.first_receiver;
    read.clock_drift = 1e-6 * number_or(item.find("clock_drift_ppm"), 0.0);
    read.clock_drift_sigma = 1e-6 * number_or(item.find("clock_drift_sigma_ppm"), 0.0);
    if (const JsonValue motion = item.find("motion"); motion.present())
      read.motion = MotionPrior{motion.at("speed_mps").number(kPositive),
                                motion.at("acceleration_mps2").number(kPositive),
                                motion.at("turn_rate_rad_per_s").number(kPositive),
                                motion.at("turn_acceleration_rad_per_s2").number(kPositive)};
    read.rail = read_deployed_rail(item.find("rail"));
  }
  if (d.vehicles.empty()) json.fail("empty", "at least one vehicle");
}

/// Unknown parameters, those of a later program, are left out: the covariance of the others is the marginal
/// one.
void read_covariance(const JsonValue& json, const ParameterLookup& lookup, JointCovariance& c) {
  const std::vector<std::string> names = json.at("parameters").texts();
  const std::size_t n = names.size();
  const std::vector<double> triangle = json.at("upper_triangle").numbers(n * (n + 1) / 2);
  Eigen::MatrixXd all(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    for (Eigen::Index j = i; j < all.cols() && k < triangle.size(); ++j)
      all(i, j) = all(j, i) = triangle[k++];
  }
  std::vector<Eigen::Index> known;
  for (std::size_t i = 0; i < n; ++i)
    if (const auto id = lookup.find(names[i])) {
      c.parameters.push_back(*id);
      known.push_back(static_cast<Eigen::Index>(i));
    }
  c.matrix = all(known, known);
}

void read_statistics(const JsonValue& json, CalibrationStatistics& s) {
  s.arrivals = json.at("arrivals").count();
  s.rejected = json.at("rejected").count();
  s.unknowns = json.at("unknowns").count();
  s.redundancy = json.at("redundancy").number();
  s.variance_factor = json.at("variance_factor").number();
  s.chi2_p = json.at("chi2_p").number();
  s.rms_s = json.at("rms_s").number();
  s.converged = json.at("converged").boolean();
}

std::optional<std::array<double, 2>> optional_pair(const JsonValue& json) {
  if (!json.present()) return {};
  const std::vector<double> v = json.numbers(2);
  return {{v[0], v[1]}};
}

void read_validity(const JsonValue& json, Deployment& d) {
  d.validity_temperature_degC = optional_pair(json.find("temperature_degC"));
  d.validity_heights_m = optional_pair(json.find("heights_m"));
  d.validity_period = {optional_number(json.find("months")),
                       optional_number(json.find("beacon_drift_m_per_month"))};  // until follows from these
  for (const JsonValue& corner : json.find("area").items()) {
    const std::vector<double> v = corner.numbers(2);
    d.validity_area_m.emplace_back(v[0], v[1]);
  }
  d.validity_reach_m = optional_number(json.find("reach_m"), kPositive);
}

void read_drift(const JsonValue& json, Deployment& d) {
  d.drift = {optional_number(json.find("beacon_m_per_year"), kNotNegative),
             optional_number(json.find("delay_m_per_year"), kNotNegative),
             optional_number(json.find("receiver_m_per_year"), kNotNegative),
             optional_number(json.find("speed_mps_per_year"), kNotNegative)};
}

void read_provenance(const JsonValue& root, Deployment& d) {
  const JsonValue datum = root.at("datum");
  d.datum.description = datum.find("description").text();
  d.datum.position = datum.find("position").text();
  d.datum.orientation = datum.find("orientation").text();
  d.datum.scale = datum.find("scale").text();
  d.datum.control_points = datum.find("control_points").texts();
  d.tolerance.beacon_m = optional_number(root.find("tolerance").find("beacon_m"));
  d.tolerance.fix_m = optional_number(root.find("tolerance").find("fix_m"));
  for (const JsonValue& input : root.at("inputs").items())
    d.inputs.push_back({input.at("path").text(), input.at("sha256").text()});
  const JsonValue program = root.at("program");
  d.program_version = program.find("version").text();
  d.program_command = program.find("command").text();
  d.warnings = root.find("warnings").texts();
}

void read_contradictions(const JsonValue& verdict, std::vector<Contradiction>& contradictions) {
  if (!verdict.present()) return;
  for (const JsonValue& c : verdict.find("contradictions").items()) {
    const std::string kind = c.at("kind").text();
    const auto known = contradiction_kind(kind);
    if (!known) {
      c.at("kind").fail(in_quotes(kind), "a kind of contradiction, such as 'control_point'",
                        "octant schema deployment lists them");
      return;
    }
    contradictions.push_back({*known, c.at("subject").text(), c.at("stated").text(), c.at("found").text(),
                              c.at("sigmas").number(kNotNegative), c.at("remedy").text()});
  }
}

Change read_change(const JsonValue& json) {
  Change c;
  const std::string kind = json.at("kind").text();
  if (const auto known = change_kind(kind)) {
    c.kind = *known;
  } else {
    json.at("kind").fail(in_quotes(kind), "a kind of change, such as 'beacon_moved'",
                         "octant schema deployment lists them");
  }
  c.subject = json.at("subject").text();
  c.size = json.at("size").number();
  c.sigma = json.at("sigma").number(kNotNegative);
  c.p = json.at("p").number(kNotNegative);
  return c;
}

void read_previous(const JsonValue& json, const ParameterLookup& lookup, Deployment& d) {
  if (!json.present()) return;
  Previous previous;
  previous.sha256 = json.at("sha256").text();
  previous.created = json.at("created").text();
  const JsonValue drift = json.at("drift");
  previous.drift = {
      drift.at("beacon_m").number(kNotNegative),   drift.at("delay_s").number(kNotNegative),
      drift.at("receiver_m").number(kNotNegative), drift.at("speed_mps").number(kNotNegative),
      drift.at("log_gain").number(kNotNegative),   drift.at("attenuation").number(kNotNegative)};
  for (const std::string& name : json.at("released").texts())
    if (name == "datum") {
      previous.released.datum = true;
    } else if (const auto id = lookup.find(name)) {
      previous.released.parameters.push_back(*id);
    }
  for (const JsonValue& change : json.at("changes").items()) previous.changes.push_back(read_change(change));
  d.previous = std::move(previous);
}

void check_head(const JsonValue& root) {
  if (const std::string type = root.at("type").text(); type != "octant_deployment") {
    root.at("type").fail(in_quotes(type), "'octant_deployment'",
                         "is this a file that octant calibrate wrote?");
  }
  if (const double version = root.at("version").number(); version != 1.0) {
    root.at("version").fail(exact(version), "1", "a newer version of the format needs a newer octant");
  }
}

/// A file of another program may have no digest; an altered file of this program has a wrong one.
void check_digest(const JsonValue& root, const nlohmann::json& json, std::vector<std::string>& warnings,
                  const JsonLog& log) {
  const JsonValue digest = root.find("digest");
  if (!digest.present()) {
    if (!log.error) warnings.push_back(log.file + ": there is no digest, so alterations cannot be noticed");
    return;
  }
  const std::string stated = digest.text(), found = digest_of(json);
  if (!log.error && stated != found) {
    digest.fail(in_quotes(stated.substr(0, 12)) + ", and the content's is " + in_quotes(found.substr(0, 12)),
                "the same",
                "the file was altered after octant wrote it: take the original, or calibrate again");
  }
}

}  // namespace

Result<void> check_no_site_file(const std::string& text, const std::string& file) {
  if (without_bom(text).find("octant_site:") == std::string_view::npos || text.starts_with('{')) return {};
  return fail({.file = file,
               .found = "a site file",
               .expected = "a deployment file, which octant calibrate makes of a site file and a recording"});
}

Result<Deployment> deployment_from_json(const std::string& text, const std::string& file) {
  if (auto ok = check_no_site_file(text, file); !ok) return fail(ok.error());
  const Result<nlohmann::json> json = parse_json(text, file);
  if (!json) return fail(json.error());
  JsonLog log{file, text, std::nullopt};
  try {
    const JsonValue root(&*json, "", log);
    std::vector<std::string> warnings;
    check_head(root);
    check_digest(root, *json, warnings, log);
    if (log.error) return fail(*log.error);
    Deployment d;
    d.site = root.at("site").text();
    d.created = root.at("created").text();
    d.motion = root.at("motion").choice<Motion>({{"planar", Motion::kPlanar}, {"spatial", Motion::kSpatial}});
    read_deployed_medium(root.at("medium"), d);
    read_deployed_timing(root.at("timing"), d.timing);
    read_deployed_noise(root.at("noise"), d.noise);
    read_correlated_noise(root.at("noise").find("correlated"), d.correlated_noise);
    if (const JsonValue a = root.find("attenuation"); a.present()) {
      AttenuationModel& model = d.attenuation.emplace();
      model.amplitude_1m_v = a.at("amplitude_1m_v").number(kPositive);
      model.absorption_np_per_m = a.at("absorption_np_per_m").number();
      model.threshold_v = a.at("threshold_v").number(kNotNegative);
      model.rise_time_s = a.at("rise_time_s").number(kNotNegative);
      model.half_power_angle_rad = number_or(a.find("half_power_angle_rad"), 0.0, kHalfPowerAngle);
      model.saturation_v = number_or(a.find("saturation_v"), model.saturation_v, kPositive);
    }
    read_deployed_beacons(root.at("beacons"), d);
    read_deployed_vehicles(root.at("vehicles"), d);
    const NameTable names = names_of(d);
    const ParameterLookup lookup(names);
    read_covariance(root.at("covariance"), lookup, d.covariance);
    read_statistics(root.at("statistics"), d.statistics);
    read_validity(root.at("validity"), d);
    read_drift(root.find("drift"), d);
    read_provenance(root, d);
    read_previous(root.find("previous"), lookup, d);
    read_contradictions(root.find("verdict"), d.contradictions);
    d.digest = digest_of(*json);
    d.warnings.insert(d.warnings.end(), warnings.begin(), warnings.end());
    if (log.error) return fail(*log.error);
    return d;
  } catch (const std::exception& e) {
    return fail({.file = file, .found = std::string("cannot be read: ") + e.what()});
  }
}

Result<Deployment> read_deployment(const std::string& path) {
  if (std::error_code ignored; std::filesystem::is_directory(path, ignored))
    return fail({.file = path,
                 .found = "this is a folder",
                 .expected = "a deployment file, which stands before the run folders",
                 .advice = "octant calibrate makes one"});
  return read_document(path).and_then(
      [&path](const std::string& text) { return deployment_from_json(text, path); });
}

}  // namespace octant::io
