// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/site_yaml.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "io/site/profile_csv.h"
#include "io/site/site_parts.h"
#include "io/text/open_file.h"
#include "io/yaml/yaml_reader.h"

namespace octant::io {
namespace {

constexpr std::size_t kHeadBytes = 65536;  // in which a deployment says that it is one

/// `profile`: a table beside the site file, or the levels themselves as [height_m, speed_mps].
void read_profile_block(YamlMap& map, Medium& medium, YamlLog& log) {
  const YamlNode node = map.block("profile");
  if (!node.is_defined() || log.error) return;
  if (medium.model != MediumModel::kConstant)
    return map.fail("profile", "a profile beside a model of the air", "model: constant, or no profile");
  if (!node.is_sequence()) {
    const std::filesystem::path file = text_of(node, map.path("profile"), log);
    if (log.error) return;
    auto profile = read_profile((std::filesystem::path(log.file).parent_path() / file).string());
    if (!profile) {
      log.error = profile.error();
      return;
    }
    medium.profile = std::make_shared<const SpeedProfile>(std::move(*profile));
    return;
  }
  std::vector<SpeedProfile::Level> levels;
  for (const Eigen::Vector2d& level : points_of<2>(node, map.path("profile"), log)) {
    if (!(level[1] > 0) || (!levels.empty() && !(level[0] > levels.back().height_m)))
      return map.fail("profile", fmt::format("a level [{}, {}]", exact(level[0]), exact(level[1])),
                      "levels [height_m, speed_mps] from below upwards, speeds above zero");
    levels.push_back({level[0], level[1]});
  }
  if (!log.error && levels.empty()) map.fail("profile", "an empty list", "one level or more");
  if (!log.error) medium.profile = std::make_shared<const SpeedProfile>(std::move(levels));
}

void read_medium(const YamlNode& node, Site& site, YamlLog& log) {
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
  medium.temperature_degC = map.number("temperature_degC", medium.temperature_degC, kCelsius);
  medium.relative_humidity = map.number("relative_humidity", medium.relative_humidity, kRelativeHumidity);
  medium.pressure_pa = map.number("pressure_pa", medium.pressure_pa, kPascals);
  read_profile_block(map, medium, log);
  if (medium.model == MediumModel::kConstant && !map.has("speed_mps") && !medium.profile) {
    map.fail_missing("speed_mps", "the speed in m/s (sound in air 343, in sea water 1500, radio 299792458)");
  }
  const double usual_mps = medium.profile
                               ? medium.profile->mean_speed_mps(medium.profile->levels().front().height_m,
                                                                medium.profile->levels().back().height_m)
                               : medium.speed_mps;
  medium.speed_mps = map.number("speed_mps", usual_mps, kPositive);
  if (!map.has("sigma_mps"))
    log.warn(node, "medium.sigma_mps is not given; the speed is fixed (sigma_mps: 0)");
  site.speed_sigma_mps = map.number("sigma_mps", 0.0, kNotNegative);
  site.speed_offset_per_run = map.choice<bool>("offset_per", {{"site", false}, {"run", true}}, false);
  map.finish();
}

DelayPer read_delay_per(const YamlNode& node, YamlLog& log) {
  DelayPer per;
  const std::vector<std::pair<std::string, bool DelayPer::*>> choices = {{"beacon", &DelayPer::beacon},
                                                                         {"receiver", &DelayPer::receiver},
                                                                         {"site", &DelayPer::site},
                                                                         {"none", nullptr}};
  std::vector<YamlNode> items;
  if (node.is_sequence()) {
    items = list_of(node, "timing.delay_per", log);
  } else {
    items.push_back(node);
  }
  for (const YamlNode& item : items) {
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

void read_timing(const YamlNode& node, Site& site, YamlLog& log) {
  YamlMap map(node, "timing", log);
  site.timing_given = map.present();
  if (!map.present()) return;
  Timing& timing = site.timing;
  timing.clock = map.choice<Clock>("clock",
                                   {{"synchronised", Clock::kSynchronised},
                                    {"cycle_offset", Clock::kCycleOffset},
                                    {"free", Clock::kCycleOffset}},
                                   timing.clock);
  for (const char* of_clocks : {"oscillator", "allan_deviation"}) map.get(of_clocks);  // clocks/clock_yaml.cc
  timing.ranging = map.choice<Ranging>(
      "ranging", {{"one_way", Ranging::kOneWay}, {"two_way", Ranging::kTwoWay}}, timing.ranging);
  timing.turnaround_s = map.number("turnaround_s", 0.0, kNotNegative);
  if (map.has("delay_per")) {
    timing.delay_per = read_delay_per(map.get("delay_per"), log);
  } else if (map.get("delay_per").is_defined()) {
    map.fail_missing("delay_per", "beacon, receiver, site, none, or a list");
  }
  timing.delay_s = map.number("delay_s", 0.0);
  timing.delay_sigma_s = map.number("delay_sigma_s", 0.0, kNotNegative);
  timing.drift = 1e-6 * map.number("drift_ppm", 0.0);
  timing.drift_sigma = 1e-6 * map.number("drift_sigma_ppm", 0.0, kNotNegative);
  if (timing.clock != Clock::kCycleOffset && (timing.drift != 0.0 || timing.drift_sigma > 0))
    map.fail(timing.drift != 0.0 ? "drift_ppm" : "drift_sigma_ppm", "a drift of a synchronised clock",
             "clock: cycle_offset, or no drift",
             "if radio or a wire marks each firing, the drift of a clock has no effect");
  map.finish();
}

void read_noise(const YamlNode& node, Site& site, YamlLog& log) {
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

/// {value: 12.5, sigma: 3.0}, or the value alone, which is then fixed.
Prior read_prior(YamlMap& parent, const char* key, NumberRange range, YamlLog& log) {
  const YamlNode node = parent.block(key);
  if (!node.is_defined()) {
    parent.fail_missing(key, "{value: ..., sigma: ...}");
    return {};
  }
  if (node.is_scalar()) return {number_of(node, parent.path(key), log, range), 0.0};
  YamlMap map(node, parent.path(key), log);
  const Prior prior{map.required_number("value", range), map.required_number("sigma", kNotNegative)};
  map.finish();
  return prior;
}

void read_attenuation(const YamlNode& node, Site& site, YamlLog& log) {
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

/// Read after the tolerance, with which a drift is compared.
void read_validity_period(YamlMap& root, Site& site, YamlLog& log) {
  YamlMap validity(root.block("validity"), "validity", log);
  site.validity.months = validity.optional_number("months", kPositive);
  site.validity.beacon_drift_m_per_month = validity.optional_number("beacon_drift_m_per_month", kPositive);
  if (site.validity.beacon_drift_m_per_month && !site.tolerance.beacon_m)
    validity.fail("beacon_drift_m_per_month", "a drift without a limit",
                  "tolerance.beacon_m, which beacons leave one day", "state tolerance: {beacon_m: 0.03}");
  validity.finish();
}

void read_drift(YamlMap& root, Site& site, YamlLog& log) {
  YamlMap drift(root.block("drift"), "drift", log);
  site.drift.beacon_m_per_year = drift.optional_number("beacon_m_per_year", kNotNegative);
  site.drift.delay_m_per_year = drift.optional_number("delay_m_per_year", kNotNegative);
  site.drift.receiver_m_per_year = drift.optional_number("receiver_m_per_year", kNotNegative);
  site.drift.speed_mps_per_year = drift.optional_number("speed_mps_per_year", kNotNegative);
  drift.finish();
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
  control.each("distances", site.distances, [&](YamlMap& map, ControlDistance& distance) {
    distance.from = read_beacon_name(map, "from", site, log);
    distance.to = read_beacon_name(map, "to", site, log);
    if (distance.from.valid() && distance.from == distance.to) {
      map.fail("to", map.path("to") + " is the same beacon as 'from'", "two different beacons");
    }
    distance.distance_m = map.required_number("distance_m", kPositive);
    distance.sigma_m = map.required_number("sigma_m", kNotNegative);
  });
  control.finish();
}

/// Warns about delays that are fixed because their sigma is not stated.
void warn_of_held_delays(YamlMap& root, const Site& site, YamlLog& log) {
  const YamlNode node = root.block("timing");
  const DelayPer& per = site.timing.delay_per;
  if (per.none() || YamlMap(node, "timing", log).has("delay_sigma_s")) return;
  const bool all_state_their_own =
      per.beacon && !per.receiver && !per.site && !site.beacons.empty() &&
      std::ranges::all_of(site.beacons, [](const SiteBeacon& b) { return b.delay_sigma_s.has_value(); });
  if (!all_state_their_own)
    log.warn(node, "timing.delay_sigma_s is not given; the delays are fixed (delay_sigma_s: 0)");
}

/// Checks the keys that a directional attenuation needs.
void check_axes(YamlMap& root, const Site& site, YamlLog& log) {
  if (log.error || !site.attenuation || !(site.attenuation->half_power_angle_rad.value > 0)) return;
  for (const SiteReceiver& receiver : site.receivers)
    if (receiver.axis) return;
  root.fail("attenuation", "attenuation.half_power_angle_rad, and no receiver has an axis",
            "axis: [x, y, z] of the receivers, or layout: octagon",
            "the half-power angle is measured from the axis of a receiver");
}

}  // namespace

Result<Site> site_from_yaml(const YamlNode& node, const std::string& file, bool version_required) {
  YamlLog log(file);
  Site site;
  site.path = file;
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
  warn_of_held_delays(root, site, log);
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
  read_validity_period(root, site, log);
  read_drift(root, site, log);
  root.get("scene");  // scene_yaml.cc's
  root.finish();
  if (log.error) return fail(*log.error);
  site.warnings = std::move(log.warnings);
  return site;
}

Result<Site> read_site(const std::string& path) {
  if (std::error_code ignored; std::filesystem::is_directory(path, ignored))
    return fail({.file = path,
                 .found = "this is a folder",
                 .expected = "a site file, which stands before the run folders",
                 .advice = "octant init RUN -o site.yaml begins one"});
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  const std::string_view text = map->text(), head = text.substr(0, kHeadBytes);
  if (head.find("\"octant_deployment\"") != std::string_view::npos &&
      head.find_first_not_of(" \t\r\n") == head.find('{'))
    return fail({.file = path,
                 .found = "a deployment file",
                 .expected = "a site file (octant schema site): what is known before a calibration",
                 .advice = "to hold a recording against a deployment: octant monitor, or verify where the "
                           "poses are known; to carry it over "
                           "to a new recording: octant recalibrate"});
  return parse_yaml(text, path).and_then([&path](const YamlNode& root) {
    return site_from_yaml(root, path);
  });
}

}  // namespace octant::io
