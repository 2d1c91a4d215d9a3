// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/site_yaml.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <fmt/format.h>

#include "io/text/atomic_file.h"
#include "io/text/yaml_reader.h"
#include "models/physics/receiver_array.h"

namespace octant::io {
namespace {

constexpr NumberRange kTemperature{
    .low = -100.0, .high = 100.0, .words = "degrees Celsius from -100 to 100 (20 degC are 293 K)"};
constexpr NumberRange kHumidity{.low = 0.0, .high = 1.0, .words = "a fraction from 0 to 1 (50 % is 0.5)"};
constexpr NumberRange kPressure{
    .low = 1.0e4, .high = 1.0e7, .words = "pascals, such as 101325 (1013 hPa are 101300)"};

/// Ids of one kind; a second use of one is an error that names both lines.
class UniqueIds {
 public:
  UniqueIds(const char* kind, YamlLog& log) : kind_(kind), log_(log) {}

  std::string take(YamlMap& map) {
    std::string id = map.required_text("id");
    if (log_.error) return id;
    const YAML::Node node = map.get("id");
    const bool odd = std::any_of(id.begin(), id.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
    if (id.empty() || id.size() > 200 || odd || id.front() == ' ' || id.back() == ' ') {
      log_.fail(node, fmt::format("{} is {}", map.path("id"), in_quotes(id)),
                "a name of up to 200 characters on one line");
    }
    const auto [first, is_new] = lines_.emplace(id, line_of(node));
    if (!is_new) {
      log_.fail(node,
                fmt::format("{} id {} is used twice (first in line {})", kind_, in_quotes(id), first->second),
                "each id once", "rename one of them");
    }
    return id;
  }

 private:
  const char* kind_;
  YamlLog& log_;
  std::unordered_map<std::string, int> lines_;
};

void read_medium(const YAML::Node& node, Site& site, YamlLog& log) {
  YamlMap map(node, "medium", log);
  site.medium_given = map.present();
  if (!map.present()) return;
  Medium& medium = site.medium;
  if (!map.has("model")) map.fail_missing("model", "cramer1993, linear_temperature or constant");
  medium.model = map.choice<MediumModel>("model",
                                         {{"cramer1993", MediumModel::kCramer1993},
                                          {"linear_temperature", MediumModel::kLinearTemperature},
                                          {"constant", MediumModel::kConstant}},
                                         medium.model);
  const auto assumed = [&](const char* key, double value) {
    log.warn(node, fmt::format("{} is not given; {} is assumed", map.path(key), exact(value)));
  };
  const bool needs_state = medium.model != MediumModel::kConstant && !log.error;
  if (needs_state && !map.has("temperature_degC")) assumed("temperature_degC", medium.temperature_degC);
  if (needs_state && medium.model == MediumModel::kCramer1993) {
    if (!map.has("relative_humidity")) assumed("relative_humidity", medium.relative_humidity);
    if (!map.has("pressure_pa")) assumed("pressure_pa", medium.pressure_pa);
  }
  medium.temperature_degC = map.number("temperature_degC", medium.temperature_degC, kTemperature);
  medium.relative_humidity = map.number("relative_humidity", medium.relative_humidity, kHumidity);
  medium.pressure_pa = map.number("pressure_pa", medium.pressure_pa, kPressure);
  if (medium.model == MediumModel::kConstant && !map.has("speed_mps")) {
    map.fail_missing("speed_mps", "the speed in m/s (sound in air 343, in sea water 1500, radio 299792458)");
  }
  medium.speed_mps = map.number("speed_mps", medium.speed_mps, kPositive);
  if (!map.has("sigma_mps"))
    log.warn(node, "medium.sigma_mps is not given; the speed is held fixed (sigma_mps: 0)");
  site.speed_sigma_mps = map.number("sigma_mps", 0.0, kNotNegative);
  site.speed_offset_per_run = map.choice<bool>("offset_per", {{"site", false}, {"run", true}}, false);
  map.finish();
}

DelayPer read_delay_per(const YAML::Node& node, YamlLog& log) {
  DelayPer per;
  const std::vector<std::pair<std::string, bool DelayPer::*>> choices = {{"beacon", &DelayPer::beacon},
                                                                         {"receiver", &DelayPer::receiver},
                                                                         {"site", &DelayPer::site},
                                                                         {"none", nullptr}};
  std::vector<YAML::Node> items;
  if (node.IsSequence()) {
    items = list_of(node, "timing.delay_per", log);
  } else {
    items.push_back(node);
  }
  for (const YAML::Node& item : items) {
    const auto member = YamlMap::choice_of<bool DelayPer::*>(item, "timing.delay_per", choices, nullptr, log);
    if (member != nullptr) {
      per.*member = true;
    } else if (items.size() > 1) {
      log.fail(item, "timing.delay_per has 'none' beside others",
               "none alone, or a list of beacon, receiver, site");
    }
  }
  return per;
}

void read_timing(const YAML::Node& node, Site& site, YamlLog& log) {
  YamlMap map(node, "timing", log);
  site.timing_given = map.present();
  if (!map.present()) return;
  Timing& timing = site.timing;
  timing.clock = map.choice<Clock>(
      "clock", {{"synchronised", Clock::kSynchronised}, {"cycle_offset", Clock::kCycleOffset}}, timing.clock);
  timing.ranging = map.choice<Ranging>(
      "ranging", {{"one_way", Ranging::kOneWay}, {"two_way", Ranging::kTwoWay}}, timing.ranging);
  timing.turnaround_s = map.number("turnaround_s", 0.0, kNotNegative);
  if (map.has("delay_per")) {
    timing.delay_per = read_delay_per(map.get("delay_per"), log);
  } else if (map.get("delay_per").IsDefined()) {
    map.fail_missing("delay_per", "beacon, receiver, site, none, or a list");
  }
  timing.delay_s = map.number("delay_s", 0.0);
  if (!timing.delay_per.none() && !map.has("delay_sigma_s")) {
    log.warn(node, "timing.delay_sigma_s is not given; the delays are held fixed (delay_sigma_s: 0)");
  }
  timing.delay_sigma_s = map.number("delay_sigma_s", 0.0, kNotNegative);
  timing.drift = 1e-6 * map.number("drift_ppm", 0.0);
  timing.drift_sigma = 1e-6 * map.number("drift_sigma_ppm", 0.0, kNotNegative);
  if (timing.clock != Clock::kCycleOffset && (timing.drift != 0.0 || timing.drift_sigma > 0))
    map.fail(timing.drift != 0.0 ? "drift_ppm" : "drift_sigma_ppm", "a drift of a synchronised clock",
             "clock: cycle_offset, or no drift",
             "where radio or wire marks each firing there is no time for a clock to drift");
  map.finish();
}

void read_noise(const YAML::Node& node, Site& site, YamlLog& log) {
  YamlMap map(node, "noise", log);
  Noise& noise = site.noise;
  site.tof_sigma_given = map.has("tof_sigma_s");
  noise.tof_sigma_s = map.number("tof_sigma_s", noise.tof_sigma_s, kPositive);
  noise.amplitude_relative_sigma =
      map.number("amplitude_relative_sigma", noise.amplitude_relative_sigma, kPositive);
  noise.pair_sigma_s = map.optional_number("pair_sigma_s", kNotNegative);
  noise.bearing_sigma_rad = map.number("bearing_sigma_rad", noise.bearing_sigma_rad, kPositive);
  noise.range_sigma_m = map.number("range_sigma_m", noise.range_sigma_m, kPositive);
  map.finish();
}

/// {value: 12.5, sigma: 3.0}, or the value alone: held fixed.
Prior read_prior(YamlMap& parent, const char* key, NumberRange range, YamlLog& log) {
  const YAML::Node node = parent.block(key);
  if (!node.IsDefined()) {
    parent.fail_missing(key, "{value: ..., sigma: ...}");
    return {};
  }
  if (node.IsScalar()) return {number_of(node, parent.path(key), log, range), 0.0};
  YamlMap map(node, parent.path(key), log);
  const Prior prior{map.required_number("value", range), map.required_number("sigma", kNotNegative)};
  map.finish();
  return prior;
}

void read_attenuation(const YAML::Node& node, Site& site, YamlLog& log) {
  YamlMap map(node, "attenuation", log);
  if (!map.present()) return;
  AttenuationPrior prior;
  prior.amplitude_1m_v = read_prior(map, "amplitude_1m_v", kPositive, log);
  prior.absorption_np_per_m = read_prior(map, "absorption_np_per_m", kNotNegative, log);
  prior.threshold_v = map.required_number("threshold_v", kNotNegative);
  prior.rise_time_s = read_prior(map, "rise_time_s", kNotNegative, log);
  if (map.has("half_power_angle_rad"))
    prior.half_power_angle_rad = read_prior(map, "half_power_angle_rad", kHalfPowerAngle, log);
  if (const auto saturation_v = map.optional_number("saturation_v", kPositive)) {
    prior.saturation_v = *saturation_v;
    if (!log.error && !(prior.saturation_v > prior.threshold_v))
      map.fail("saturation_v", fmt::format("attenuation.saturation_v is {}", prior.saturation_v),
               "more than threshold_v");
  }
  map.finish();
  site.attenuation = prior;
}

using Coordinates = std::array<std::optional<double>, 3>;

/// [x, y, z], each a number or null.
Coordinates read_coordinates(const YAML::Node& node, const std::string& name, NumberRange range,
                             YamlLog& log) {
  Coordinates values;
  const std::vector<YAML::Node> items = list_of(node, name, log, 3);
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!items[i].IsNull()) values[i] = number_of(items[i], fmt::format("{}[{}]", name, i), log, range);
  }
  return values;
}

/// A number for all three axes, or [sx, sy, sz].
Coordinates read_sigmas(const YAML::Node& node, const std::string& name, YamlLog& log) {
  if (!node.IsDefined()) return {};
  if (node.IsSequence()) return read_coordinates(node, name, kNotNegative, log);
  const double sigma = number_of(node, name, log, kNotNegative);
  return {sigma, sigma, sigma};
}

void read_beacons(YamlMap& root, Site& site, YamlLog& log) {
  if (!root.has("beacons"))
    root.fail_missing("beacons", "a list of beacons (beacons: [] where there are none)");
  UniqueIds ids("beacon", log);
  for (const YAML::Node& node : root.list("beacons")) {
    if (log.error) return;
    YamlMap map(node, fmt::format("beacons[{}]", site.beacons.size()), log);
    SiteBeacon beacon;
    beacon.line = line_of(node);
    beacon.name = ids.take(map);
    if (const YAML::Node at = map.block("position_m"); at.IsDefined()) {
      beacon.position_m = read_coordinates(at, map.path("position_m"), kAnyNumber, log);
    }
    beacon.sigma_m = read_sigmas(map.block("sigma_m"), map.path("sigma_m"), log);
    map.finish();
    site.beacons.push_back(std::move(beacon));
  }
}

Eigen::Vector3d read_receiver_sigma(YamlMap& map, YamlLog& log) {
  const Coordinates sigmas = read_sigmas(map.block("sigma_m"), map.path("sigma_m"), log);
  return {sigmas[0].value_or(0.0), sigmas[1].value_or(0.0), sigmas[2].value_or(0.0)};
}

/// {layout: octagon, side_m: 0.050, height_m: 0.30, sigma_m: 0.002}
void read_layout(const YAML::Node& node, const std::string& name, VehicleId vehicle, Site& site,
                 YamlLog& log) {
  YamlMap map(node, name, log);
  map.choice<int>("layout", {{"octagon", 0}}, 0);
  if (!map.has("layout")) map.fail_missing("layout", "layout: octagon, or a list of receivers");
  const double side_m = map.required_number("side_m", kPositive);
  const double height_m = map.required_number("height_m");
  const double turn_rad = map.number("turn_rad", 0.0);
  const Eigen::Vector3d sigma_m = read_receiver_sigma(map, log);
  map.finish();
  if (log.error) return;
  int corner = 0;
  for (const ArrayElement& element : octagon(side_m, height_m, turn_rad)) {
    site.receivers.push_back(
        {fmt::format("r{}", corner++), vehicle, element.position_m, sigma_m, element.axis});
  }
}

std::optional<Eigen::Vector3d> read_axis(YamlMap& map, YamlLog& log) {
  const std::vector<double> numbers = map.numbers("axis", 3);
  if (numbers.size() != 3 || log.error) return std::nullopt;
  const Eigen::Vector3d axis(numbers[0], numbers[1], numbers[2]);
  const double norm = axis.norm();
  if (!(norm > 1e-9) || !std::isfinite(norm)) {
    map.fail("axis", map.path("axis") + " has no length", "a direction, such as [1, 0, 0]");
    return std::nullopt;
  }
  // A vector that is of unit length to the last digits is left alone, so that a written file reads back the
  // same.
  return std::abs(norm - 1.0) < 1e-14 ? axis : Eigen::Vector3d(axis / norm);
}

void read_receivers(YamlMap& vehicle_map, VehicleId vehicle, Site& site, YamlLog& log) {
  const YAML::Node node = vehicle_map.block("receivers");
  if (!node.IsDefined()) return;  // bearings and scans need none
  const std::string name = vehicle_map.path("receivers");
  if (node.IsMap()) return read_layout(node, name, vehicle, site, log);
  UniqueIds ids("receiver", log);
  for (const YAML::Node& item : list_of(node, name, log)) {
    if (log.error) return;
    YamlMap map(
        item,
        fmt::format("{}[{}]", name, site.receivers.size() - site.vehicles[vehicle.index()].first_receiver),
        log);
    SiteReceiver receiver;
    receiver.vehicle = vehicle;
    receiver.name = ids.take(map);
    const std::vector<double> at = map.numbers("position_m", 3);
    if (at.size() == 3) {
      receiver.position_m = {at[0], at[1], at[2]};
    } else {
      map.fail_missing("position_m", "[x, y, z] in the vehicle frame");
    }
    receiver.sigma_m = read_receiver_sigma(map, log);
    receiver.axis = read_axis(map, log);
    map.finish();
    site.receivers.push_back(std::move(receiver));
  }
}

/// array: {radius_sigma_m: 0.002, turn_sigma_rad: 0.02}: the receivers as one piece, adjusted by its radius
/// and its turn.
void read_array(YamlMap& vehicle_map, SiteVehicle& vehicle, const Site& site, YamlLog& log) {
  const YAML::Node node = vehicle_map.block("array");
  if (!node.IsDefined()) return;
  YamlMap map(node, vehicle_map.path("array"), log);
  vehicle.array = ArrayShape{map.number("radius_sigma_m", 0.0, kNotNegative),
                             map.number("turn_sigma_rad", 0.0, kNotNegative)};
  map.finish();
  if (log.error) return;
  for (std::size_t r = vehicle.first_receiver; r < site.receivers.size(); ++r) {
    const SiteReceiver& receiver = site.receivers[r];
    if (receiver.sigma_m.maxCoeff() > 0)
      return vehicle_map.fail(
          "array", fmt::format("an array as one piece, and sigma_m of its receiver {}", receiver.name),
          "either array, or sigma_m of the receivers",
          "leave sigma_m out (0) to adjust only the array's radius and turn");
    if (!(receiver.position_m.head<2>().norm() > 0))
      return vehicle_map.fail("array", fmt::format("receiver {} on the array's own axis", receiver.name),
                              "receivers around the vehicle's origin");
  }
}

/// motion: {speed_mps: 1.0, acceleration_mps2: 0.5}
void read_motion(YamlMap& vehicle_map, SiteVehicle& vehicle, YamlLog& log) {
  const YAML::Node node = vehicle_map.block("motion");
  if (!node.IsDefined()) return;
  YamlMap map(node, vehicle_map.path("motion"), log);
  MotionPrior prior;
  prior.speed_mps = map.number("speed_mps", prior.speed_mps, kPositive);
  prior.acceleration_mps2 = map.number("acceleration_mps2", prior.acceleration_mps2, kPositive);
  prior.turn_rate_rad_per_s = map.number("turn_rate_rad_per_s", prior.turn_rate_rad_per_s, kPositive);
  prior.turn_acceleration_rad_per_s2 =
      map.number("turn_acceleration_rad_per_s2", prior.turn_acceleration_rad_per_s2, kPositive);
  map.finish();
  vehicle.motion = prior;
}

/// {from_m: [x, y], to_m: [x, y]}, straight, or {centre_m: [x, y], radius_m: R}, an arc.
std::optional<Rail> read_rail(const YAML::Node& node, const std::string& name, YamlLog& log) {
  YamlMap map(node, name, log);
  if (!map.present()) return std::nullopt;
  const auto point = [&](const char* key) {
    if (!map.has(key))
      map.fail_missing(key,
                       "[x, y]; a rail is {from_m: [x, y], to_m: [x, y]} or {centre_m: [x, y], radius_m: R}");
    const std::vector<double> at = map.numbers(key, 2);
    return at.size() == 2 ? Eigen::Vector2d(at[0], at[1]) : Eigen::Vector2d(0, 0);
  };
  Rail rail;
  const bool arc = map.has("centre_m") || map.has("radius_m");
  if (arc && (map.has("from_m") || map.has("to_m"))) {
    log.fail(node, name + " is both straight and an arc", "from_m and to_m, or centre_m and radius_m");
  }
  if (arc) {
    rail.shape = Rail::Shape::kArc;
    rail.centre_m = point("centre_m");
    rail.radius_m = map.required_number("radius_m", kPositive);
  } else {
    rail.from_m = point("from_m");
    rail.to_m = point("to_m");
    if (!log.error && rail.from_m == rail.to_m)
      map.fail("to_m", map.path("to_m") + " is where the rail begins", "another point");
  }
  map.finish();
  return rail;
}

void read_vehicles(YamlMap& root, Site& site, YamlLog& log) {
  UniqueIds ids("vehicle", log);
  for (const YAML::Node& node : root.list("vehicles")) {
    if (log.error) return;
    YamlMap map(node, fmt::format("vehicles[{}]", site.vehicles.size()), log);
    const VehicleId vehicle(site.vehicles.size());
    site.vehicles.push_back({map.has("id") ? ids.take(map) : "robot", site.receivers.size(), 0});
    map.get("id");
    read_receivers(map, vehicle, site, log);
    site.vehicles.back().receiver_count = site.receivers.size() - site.vehicles.back().first_receiver;
    read_array(map, site.vehicles.back(), site, log);
    read_motion(map, site.vehicles.back(), log);
    site.vehicles.back().rail = read_rail(map.block("rail"), map.path("rail"), log);
    map.finish();
  }
  if (site.vehicles.empty()) root.fail_missing("vehicles", "a list of at least one vehicle");
}

BeaconId read_beacon_name(YamlMap& map, const char* key, const Site& site, YamlLog& log) {
  const std::string name = map.required_text(key);
  for (std::size_t i = 0; i < site.beacons.size(); ++i) {
    if (site.beacons[i].name == name) return BeaconId(i);
  }
  if (!log.error) {
    map.fail(key, fmt::format("{}: beacon {} is not in the site", map.path(key), in_quotes(name)),
             "a beacon's id", suggestion(name, names_of(site).beacons));
  }
  return {};
}

void read_control(YamlMap& root, Site& site, YamlLog& log) {
  YamlMap control(root.block("control"), "control", log);
  for (const YAML::Node& node : control.list("distances")) {
    if (log.error) return;
    YamlMap map(node, fmt::format("control.distances[{}]", site.distances.size()), log);
    ControlDistance distance;
    distance.from = read_beacon_name(map, "from", site, log);
    distance.to = read_beacon_name(map, "to", site, log);
    if (distance.from.valid() && distance.from == distance.to) {
      map.fail("to", map.path("to") + " is the same beacon as 'from'", "two different beacons");
    }
    distance.distance_m = map.required_number("distance_m", kPositive);
    distance.sigma_m = map.required_number("sigma_m", kNotNegative);
    map.finish();
    site.distances.push_back(distance);
  }
  control.finish();
}

/// What a directional attenuation needs.
void check_axes(YamlMap& root, const Site& site, YamlLog& log) {
  if (log.error || !site.attenuation || !(site.attenuation->half_power_angle_rad.value > 0)) return;
  for (const SiteReceiver& receiver : site.receivers)
    if (receiver.axis) return;
  root.fail("attenuation", "attenuation.half_power_angle_rad, and no receiver has an axis",
            "axis: [x, y, z] of the receivers, or layout: octagon",
            "without directions of hearing there is nothing to be off from");
}

}  // namespace

Result<Site> site_from_yaml(const YAML::Node& node, const std::string& file, bool version_required) {
  YamlLog log(file);
  Site site;
  site.path = file;
  try {
    YamlMap root(node, "", log);
    if (version_required || root.has("octant_site")) check_version(root, "octant_site", log);
    if (log.error) return fail(*log.error);
    site.name = root.text("name", "");
    if (!root.has("motion")) root.fail_missing("motion", "motion: planar (x, y, heading) or motion: spatial");
    site.motion = root.choice<Motion>("motion", {{"planar", Motion::kPlanar}, {"spatial", Motion::kSpatial}},
                                      Motion::kPlanar);
    read_medium(root.block("medium"), site, log);
    read_timing(root.block("timing"), site, log);
    read_noise(root.block("noise"), site, log);
    read_attenuation(root.block("attenuation"), site, log);
    read_beacons(root, site, log);
    read_vehicles(root, site, log);
    check_axes(root, site, log);
    read_control(root, site, log);
    YamlMap gates(root.block("gates"), "gates", log);
    site.gates.min_range_m = gates.number("min_range_m", 0.0, kNotNegative);
    site.gates.max_range_m = gates.optional_number("max_range_m", kPositive).value_or(site.gates.max_range_m);
    site.gates.triangle = gates.boolean("triangle", true);
    gates.finish();
    YamlMap tolerance(root.block("tolerance"), "tolerance", log);
    site.tolerance.beacon_m = tolerance.optional_number("beacon_m", kPositive);
    site.tolerance.fix_m = tolerance.optional_number("fix_m", kPositive);
    tolerance.finish();
    root.get("scene");  // scene_yaml.cc's
    root.finish();
  } catch (const YAML::Exception& e) {
    return fail({.file = file, .line = e.mark.line + 1, .column = e.mark.column + 1, .found = e.msg});
  }
  if (log.error) return fail(*log.error);
  site.warnings = std::move(log.warnings);
  return site;
}

Result<Site> read_site(const std::string& path) {
  const Result<std::string> text = read_file(path);
  if (!text) return fail(text.error());
  if (text->find("\"octant_deployment\"") != std::string::npos &&
      text->find_first_not_of(" \t\r\n") == text->find('{'))
    return fail(
        {.file = path,
         .found = "a deployment file",
         .expected = "a site file (octant schema site): what is known before a calibration",
         .advice =
             "to hold a recording against a deployment: octant verify; to say what changed since: --since"});
  const Result<YAML::Node> root = parse_yaml(*text, path);
  if (!root) return fail(root.error());
  return site_from_yaml(*root, path);
}

}  // namespace octant::io
