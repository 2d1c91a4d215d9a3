// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "io/run/odometry_keys.h"
#include "io/run/run_folder.h"
#include "io/text/atomic_file.h"
#include "io/tof/run_parts.h"
#include "io/yaml/yaml_reader.h"
#include "io/yaml/yaml_writer.h"

namespace octant::io {
namespace {

void read_accuracy(const YamlNode& node, const char* name, bool observations, PoseAccuracy& accuracy,
                   YamlLog& log) {
  YamlMap map(node, name, log);
  if (!map.present()) return;
  accuracy.position_sigma_m = map.number("position_sigma_m", accuracy.position_sigma_m, kNotNegative);
  if (map.has("heading")) {
    map.choice<int>("heading", {{"unknown", 0}}, 0);
    accuracy.heading_known = false;
    if (map.has("heading_sigma_rad")) {
      map.fail("heading", fmt::format("{} has both heading: unknown and heading_sigma_rad", name),
               "one of the two");
    }
  }
  const bool has_heading = map.has("heading_sigma_rad");
  accuracy.heading_sigma_rad = map.number("heading_sigma_rad", accuracy.heading_sigma_rad, kNotNegative);
  const double attitude = has_heading ? accuracy.heading_sigma_rad : accuracy.attitude_sigma_rad;
  accuracy.attitude_sigma_rad = map.number("attitude_sigma_rad", attitude, kNotNegative);
  if (observations) accuracy.max_gap_s = map.number("max_gap_s", accuracy.max_gap_s, kNotNegative);
  map.finish();
}

void write_accuracy(const char* name, const PoseAccuracy& a, bool observations, std::string& text) {
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{}:\n  position_sigma_m: {}\n", name, a.position_sigma_m);
  if (a.heading_known) {
    fmt::format_to(out, "  heading_sigma_rad: {}\n", a.heading_sigma_rad);
  } else {
    fmt::format_to(out, "  heading: unknown\n");
  }
  fmt::format_to(out, "  attitude_sigma_rad: {}\n", a.attitude_sigma_rad);
  if (observations) fmt::format_to(out, "  max_gap_s: {}\n", a.max_gap_s);
}

}  // namespace

Result<RunHeader> parse_run_yaml(std::string_view text, const std::string& file, MeasurementLog& log) {
  const Result<YamlNode> node = parse_yaml(text, file);
  if (!node) return fail(node.error());
  YamlLog yaml(file);
  RunHeader header{"", std::numeric_limits<double>::infinity()};
  YamlMap root(*node, "", yaml);
  check_version(root, "octant_run", yaml);
  if (yaml.error) return fail(*yaml.error);
  header.vehicle = root.text("vehicle", "");
  log.temperature_degC = root.optional_number("temperature_degC", kCelsius);
  log.relative_humidity = root.optional_number("relative_humidity", kRelativeHumidity);
  log.pressure_pa = root.optional_number("pressure_pa", kPascals);
  header.range_max_m = root.number("range_max_m", header.range_max_m, kPositive);
  read_accuracy(root.block("poses"), "poses", true, log.pose_accuracy, yaml);
  read_accuracy(root.block("truth"), "truth", false, log.truth_accuracy, yaml);
  YamlMap odometry(root.block("odometry"), "odometry", yaml);
  read_odometry_keys(odometry, log.odometry_accuracy);
  if (odometry.present()) odometry.finish();
  root.finish();
  if (yaml.error) return fail(*yaml.error);
  log.warnings.insert(log.warnings.end(), yaml.warnings.begin(), yaml.warnings.end());
  return header;
}

void read_odometry_keys(YamlMap& odometry, OdometryAccuracy& accuracy) {
  const auto read = [&](const char* key, double& value) {
    value = odometry.number(key, value, kNotNegative);
  };
  read("distance_sigma_m_per_sqrt_m", accuracy.distance_sigma_m_per_sqrt_m);
  read("heading_sigma_rad_per_sqrt_m", accuracy.heading_sigma_rad_per_sqrt_m);
  read("heading_sigma_per_rad", accuracy.heading_sigma_per_rad);
  read("floor_m", accuracy.floor_m);
  read("floor_rad", accuracy.floor_rad);
}

Result<OdometryAccuracy> read_odometry_accuracy(const std::string& path, std::vector<std::string>& warnings) {
  const bool folder = std::filesystem::is_directory(path);
  const std::string file = folder ? (std::filesystem::path(path) / "run.yaml").string() : path;
  const auto text = read_file(file);
  if (!text) return fail(text.error());
  MeasurementLog log;
  if (auto header = parse_run_yaml(*text, file, log); !header) return fail(header.error());
  const Result<YamlNode> node = parse_yaml(*text, file);
  if (!node) return fail(node.error());
  YamlLog yaml(file);
  if (!YamlMap(*node, "", yaml).has("odometry"))
    return fail({.code = Errc::kBadInput,
                 .file = file,
                 .found = "nothing is said of the odometry",
                 .expected = "a block odometry: {distance_sigma_m_per_sqrt_m: 0.01, ...}",
                 .advice = "octant schema run lists its keys and what holds without them"});
  warnings.insert(warnings.end(), log.warnings.begin(), log.warnings.end());
  return log.odometry_accuracy;
}

std::string run_to_yaml(const MeasurementLog& log, const NameTable& names) {
  std::string text = "octant_run: 1\n";
  const auto out = std::back_inserter(text);
  if (log.vehicle.valid())
    fmt::format_to(out, "vehicle: {}\n", yaml_text(names.vehicles[log.vehicle.index()]));
  if (log.temperature_degC) fmt::format_to(out, "temperature_degC: {}\n", *log.temperature_degC);
  if (log.relative_humidity) fmt::format_to(out, "relative_humidity: {}\n", *log.relative_humidity);
  if (log.pressure_pa) fmt::format_to(out, "pressure_pa: {}\n", *log.pressure_pa);
  if (!log.poses.empty()) write_accuracy("poses", log.pose_accuracy, true, text);
  if (!log.truth.empty()) write_accuracy("truth", log.truth_accuracy, false, text);
  if (!log.odometry.empty()) {
    const OdometryAccuracy& a = log.odometry_accuracy;
    fmt::format_to(out, "odometry:\n  distance_sigma_m_per_sqrt_m: {}\n", a.distance_sigma_m_per_sqrt_m);
    fmt::format_to(out, "  heading_sigma_rad_per_sqrt_m: {}\n", a.heading_sigma_rad_per_sqrt_m);
    fmt::format_to(out, "  heading_sigma_per_rad: {}\n", a.heading_sigma_per_rad);
    fmt::format_to(out, "  floor_m: {}\n  floor_rad: {}\n", a.floor_m, a.floor_rad);
  }
  return text;
}

}  // namespace octant::io
