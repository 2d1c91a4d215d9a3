// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include "io/site/site_parts.h"
#include "models/physics/receiver_array.h"

namespace octant::io {
namespace {

Eigen::Vector3d read_receiver_sigma(YamlMap& map, YamlLog& log) {
  const Coordinates sigmas = read_sigmas(map.block("sigma_m"), map.path("sigma_m"), log);
  return {sigmas[0].value_or(0.0), sigmas[1].value_or(0.0), sigmas[2].value_or(0.0)};
}

/// {layout: octagon, side_m: 0.050, height_m: 0.30, sigma_m: 0.002}
void read_layout(const YamlNode& node, const std::string& name, VehicleId vehicle, Site& site, YamlLog& log) {
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

void read_receivers(YamlMap& vehicle_map, VehicleId vehicle, Site& site, YamlLog& log) {
  const YamlNode node = vehicle_map.block("receivers");
  if (!node.is_defined()) return;  // bearings and scans need none
  const std::string name = vehicle_map.path("receivers");
  if (node.is_map()) return read_layout(node, name, vehicle, site, log);
  UniqueIds ids("receiver", log);
  vehicle_map.each("receivers", site.receivers, [&](YamlMap& map, SiteReceiver& receiver) {
    receiver.vehicle = vehicle;
    receiver.name = ids.take(map);
    const std::vector<double> at = map.numbers("position_m", 3);
    if (at.size() == 3) {
      receiver.position_m = {at[0], at[1], at[2]};
    } else {
      map.fail_missing("position_m", "[x, y, z] in the vehicle frame");
    }
    receiver.sigma_m = read_receiver_sigma(map, log);
    receiver.axis = read_axis(map, "[1, 0, 0]", log);
  });
}

/// array: {radius_sigma_m: 0.002, turn_sigma_rad: 0.02}: the receivers as one piece, adjusted by its radius
/// and its turn.
void read_array(YamlMap& vehicle_map, SiteVehicle& vehicle, const Site& site, YamlLog& log) {
  const YamlNode node = vehicle_map.block("array");
  if (!node.is_defined()) return;
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
  const YamlNode node = vehicle_map.block("motion");
  if (!node.is_defined()) return;
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
std::optional<Rail> read_rail(const YamlNode& node, const std::string& name, YamlLog& log) {
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

}  // namespace

void read_vehicles(YamlMap& root, Site& site, YamlLog& log) {
  UniqueIds ids("vehicle", log);
  root.each("vehicles", site.vehicles, [&](YamlMap& map, SiteVehicle& vehicle) {
    vehicle = {ids.take(map, "robot"), site.receivers.size(), 0};
    map.get("id");
    read_receivers(map, VehicleId(site.vehicles.size()), site, log);
    vehicle.receiver_count = site.receivers.size() - vehicle.first_receiver;
    read_array(map, vehicle, site, log);
    read_motion(map, vehicle, log);
    vehicle.rail = read_rail(map.block("rail"), map.path("rail"), log);
  });
  if (site.vehicles.empty()) root.fail_missing("vehicles", "a list of at least one vehicle");
}

}  // namespace octant::io
