// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/scenario_yaml.h"

#include <utility>

#include "io/run/odometry_keys.h"
#include "io/site/site_parts.h"
#include "io/text/bounds.h"
#include "io/yaml/yaml_reader.h"

namespace octant::io {
namespace {

using Interval = std::array<double, 2>;

/// Two numbers, low and high; the fallback where the key is absent.
Interval interval(YamlMap& map, const char* key, Interval fallback, NumberRange range = kAnyNumber) {
  const std::vector<double> ends = map.numbers(key, 2, range);
  if (ends.size() != 2) return fallback;
  if (ends[0] > ends[1])
    map.fail(key, map.path(key) + ": the first number is the larger one", "[lowest, highest]");
  return {ends[0], ends[1]};
}

/// Keys that are absent stay as they are in `path`.
void read_path(const YamlNode& node, const char* name, YamlLog& log, Scenario::Path& path) {
  YamlMap map(node, name, log);
  if (!map.present()) return;
  path.kind = map.choice<PathKind>("kind",
                                   {{"stops", PathKind::kStops},
                                    {"waypoints", PathKind::kWaypoints},
                                    {"stations", PathKind::kStations},
                                    {"drive", PathKind::kDrive}},
                                   path.kind);
  if (map.has("stations")) {
    path.stations = points_of<3>(map.block("stations"), map.path("stations"), log);
    if (!path.stations.empty()) path.epochs = static_cast<int>(path.stations.size());
  }
  path.epochs = map.integer("epochs", path.epochs, 1, 10'000'000);
  path.epoch_period_s = map.number("epoch_period_s", path.epoch_period_s, kPositive);
  path.slot_s = map.number("slot_s", path.slot_s, kPositive);
  path.rounds = map.integer("rounds", path.rounds, 1, 1000);
  path.duration_s = map.number("duration_s", path.duration_s,
                               {.low = 0.0, .high = 1e6, .low_excluded = true, .words = "seconds up to 1e6"});
  path.speed_mps = map.number("speed_mps", path.speed_mps, kPositive);
  path.turn_rate_rad_per_s = map.number("turn_rate_rad_per_s", path.turn_rate_rad_per_s, kPositive);
  path.odometry_period_s = map.number("odometry_period_s", path.odometry_period_s, kPositive);
  if (map.has("waypoints_m"))
    path.waypoints_m = points_of<2>(map.block("waypoints_m"), map.path("waypoints_m"), log);
  map.finish();
}

void read_accuracies(YamlMap& root, YamlLog& log, Scenario& scenario) {
  YamlMap poses(root.block("poses"), "poses", log);
  PoseAccuracy& pose = scenario.pose_accuracy;
  if (poses.present()) {
    pose.position_sigma_m = poses.number("position_sigma_m", pose.position_sigma_m, kNotNegative);
    pose.heading_sigma_rad = poses.number("heading_sigma_rad", pose.heading_sigma_rad, kNotNegative);
    pose.attitude_sigma_rad = poses.number("attitude_sigma_rad", pose.heading_sigma_rad, kNotNegative);
    pose.max_gap_s = poses.number("max_gap_s", pose.max_gap_s, kNotNegative);
    if (poses.has("heading")) pose.heading_known = poses.choice<bool>("heading", {{"unknown", false}}, false);
    poses.finish();
  }
  YamlMap odometry(root.block("odometry"), "odometry", log);
  scenario.log_odometry = odometry.present();
  if (scenario.log_odometry) {
    read_odometry_keys(odometry, scenario.odometry_accuracy);
    odometry.finish();
  }
}

void read_world(YamlMap& root, Scenario& scenario) {
  constexpr NumberRange below_one{.low = 0.0, .high = 0.99, .words = "a fraction from 0 to 0.99"};
  const std::vector<double> hall = root.numbers("hall_m", 2, kPositive);
  if (hall.size() == 2) scenario.hall_m = {hall[0], hall[1]};
  scenario.range_m = root.number("range_m", scenario.range_m, kPositive);
  scenario.hearing_half_angle_rad =
      root.number("hearing_half_angle_rad", scenario.hearing_half_angle_rad, kPositive);
  scenario.echo_fraction = root.number("echo_fraction", scenario.echo_fraction, below_one);
  scenario.echo_delay_s = interval(root, "echo_delay_s", scenario.echo_delay_s, kPositive);
  scenario.early_fraction = root.number("early_fraction", scenario.early_fraction, below_one);
  scenario.quantum_s = root.number("quantum_s", scenario.quantum_s, kNotNegative);
  scenario.true_speed_offset_mps = root.optional_number("true_speed_offset_mps");
  scenario.true_temperature_offset_degC = root.optional_number("true_temperature_offset_degC");
  scenario.warming_degC = root.number("warming_degC", scenario.warming_degC);
  if (root.has("true_delay_s")) scenario.true_delay_s = interval(root, "true_delay_s", {0.0, 0.0});
  scenario.cycle_offset_s = interval(root, "cycle_offset_s", scenario.cycle_offset_s);
  scenario.unknown_beacons = root.boolean("unknown_beacons", scenario.unknown_beacons);
  scenario.log_amplitude = root.boolean("log_amplitude", scenario.log_amplitude);
  scenario.log_poses = root.boolean("log_poses", scenario.log_poses);
}

void read_sensors(YamlMap& root, YamlLog& log, Scenario& scenario) {
  YamlMap bearings(root.block("bearings"), "bearings", log);
  if (bearings.present()) {
    Scenario::Bearings b;
    b.range_m = bearings.number("range_m", b.range_m, kPositive);
    b.unlabelled_fraction = bearings.number("unlabelled_fraction", b.unlabelled_fraction,
                                            {.low = 0.0, .high = 1.0, .words = "a fraction from 0 to 1"});
    b.period_s = bearings.number("period_s", b.period_s, kPositive);
    bearings.finish();
    scenario.bearings = b;
  }
  YamlMap scans(root.block("scans"), "scans", log);
  if (scans.present()) {
    Scenario::Scans s;
    s.period_s = scans.number("period_s", s.period_s, kPositive);
    s.angle_min_rad = scans.number("angle_min_rad", s.angle_min_rad);
    s.angle_increment_rad = scans.number("angle_increment_rad", s.angle_increment_rad, kPositive);
    s.beams = scans.integer("beams", s.beams, 1, 10'000);
    s.range_max_m = scans.number("range_max_m", s.range_max_m, kPositive);
    scans.finish();
    scenario.scans = s;
  }
  if (const YamlNode walls = root.block("walls_m"); walls.is_defined())
    for (const Eigen::Vector4d& w : points_of<4>(walls, root.path("walls_m"), log))
      scenario.walls_m.push_back({w[0], w[1], w[2], w[3]});
}

/// The validation run follows the calibration run, with a third of its epochs or half of its time.
Scenario::Path shorter(Scenario::Path path) {
  path.epochs = (path.epochs + 2) / 3;
  path.duration_s /= 2;
  return path;
}

}  // namespace

Result<Scenario> scenario_from_yaml(std::string_view text, const std::string& file) {
  auto document = parse_yaml(text, file);
  if (!document) return fail(document.error());
  YamlLog log(file);
  YamlMap root(*document, "", log);
  check_version(root, "octant_scenario", log);
  Scenario scenario;
  const YamlNode site_node = root.block("site");
  if (!site_node.is_defined()) {
    root.fail_missing("site", "the content of a site file, with true positions");
  }
  read_path(root.block("path"), "path", log, scenario.path);
  scenario.heldout_path = shorter(scenario.path);
  read_path(root.block("heldout_path"), "heldout_path", log, scenario.heldout_path);
  read_world(root, scenario);
  read_accuracies(root, log, scenario);
  read_sensors(root, log, scenario);
  root.finish();
  if (log.error) return fail(*log.error);

  auto site = site_from_yaml(site_node, file, /*version_required=*/false);
  if (!site) return fail(site.error());
  scenario.warnings = std::move(log.warnings);
  scenario.warnings.insert(scenario.warnings.end(), site->warnings.begin(), site->warnings.end());
  site->warnings.clear();
  scenario.site = std::move(*site);
  for (const SiteBeacon& beacon : scenario.site.beacons) {
    if (beacon.position_m[0] && beacon.position_m[1] && beacon.position_m[2]) continue;
    return fail({.code = Errc::kBadInput,
                 .file = file,
                 .line = beacon.line,
                 .found = "beacon '" + beacon.name + "' has no position to simulate it at",
                 .expected = "position_m: [x, y, z], its true position",
                 .advice = "use sigma_m: null for what people do not know"});
  }
  if (auto sound = check_scenario(scenario); !sound) {
    Error error = sound.error();
    error.file = file;
    return fail(error);
  }
  return scenario;
}

Result<Scenario> read_scenario(const std::string& path) {
  return read_document(path).and_then(
      [&path](const std::string& text) { return scenario_from_yaml(text, path); });
}

}  // namespace octant::io
