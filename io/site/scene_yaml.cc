// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/scene_yaml.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "io/import/plan_import.h"
#include "io/site/site_parts.h"
#include "io/text/atomic_file.h"
#include "io/yaml/yaml_reader.h"

namespace octant::io {
namespace {

constexpr double kImportedSlack = 1.0;  ///< largest distance in pixels of a beacon inside an occupied cell

std::vector<Eigen::Vector2d> required_points(YamlMap& map, YamlLog& log, const char* key = "points_m") {
  const YamlNode node = map.block(key);
  if (!node.is_defined()) map.fail_missing(key, "a list of [x, y]");
  return node.is_defined() ? points_of<2>(node, map.path(key), log) : std::vector<Eigen::Vector2d>{};
}

std::optional<std::size_t> read_pattern_name(YamlMap& map, const char* key, const Scene& scene) {
  if (!map.has(key)) {
    map.get(key);
    return std::nullopt;
  }
  const std::string name = map.required_text(key);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < scene.patterns.size(); ++i) {
    if (scene.patterns[i].name == name) return i;
    names.push_back(scene.patterns[i].name);
  }
  map.fail(key, fmt::format("{}: there is no pattern {}", map.path(key), in_quotes(name)),
           "the id of one of scene.patterns", suggestion(name, names));
  return std::nullopt;
}

std::string id_of(YamlMap& map, const char* kind, std::size_t index) {
  return map.text("id", fmt::format("{}{}", kind, index));
}

void read_walls(YamlMap& root, const char* key, bool solid, Scene& scene, YamlLog& log) {
  std::size_t index = 0;
  root.each(key, scene.walls, [&](YamlMap& map, SceneWall& wall) {
    wall.name = id_of(map, solid ? "O" : "W", index++);
    wall.points_m = required_points(map, log);
    wall.solid = solid;
    wall.bottom_m = map.number("bottom_m", wall.bottom_m);
    wall.top_m = map.optional_number("top_m").value_or(wall.top_m);
    if (solid) {
      wall.blocks_sound = map.boolean("blocks_sound", true);
      wall.blocks_vehicle = map.boolean("blocks_vehicle", true);
    }
  });
}

void read_mounts(YamlMap& root, Scene& scene, YamlLog& log) {
  root.each("mounts", scene.mounts, [&](YamlMap& map, SceneMount& mount) {
    mount.name = id_of(map, "M", scene.mounts.size());
    if (!map.has("kind")) map.fail_missing("kind", "wall, ceiling or pole");
    mount.kind = map.choice<SceneMount::Kind>("kind",
                                              {{"wall", SceneMount::Kind::kWall},
                                               {"ceiling", SceneMount::Kind::kCeiling},
                                               {"pole", SceneMount::Kind::kPole}},
                                              mount.kind);
    mount.points_m = required_points(map, log);
    const std::vector<double> heights = map.numbers("height_m", 2);
    if (heights.size() == 2) {
      mount.low_m = heights[0], mount.high_m = heights[1];
    } else {
      map.fail_missing("height_m", "[lowest, highest]");
    }
    mount.axis = read_axis(map, "[0, 0, -1]", log);
  });
}

void read_patterns(YamlMap& root, Scene& scene) {
  root.each("patterns", scene.patterns, [](YamlMap& map, BeamPattern& pattern) {
    pattern.name = map.required_text("id");
    if (!map.has("kind")) map.fail_missing("kind", "cone, cosine_power, half_power or table");
    using Kind = BeamPattern::Kind;
    pattern.kind = map.choice<Kind>("kind",
                                    {{"cone", Kind::kCone},
                                     {"cosine_power", Kind::kCosinePower},
                                     {"half_power", Kind::kHalfPower},
                                     {"table", Kind::kTable}},
                                    pattern.kind);
    if (pattern.kind == Kind::kCone)
      pattern.half_angle_rad = map.required_number("half_angle_rad", kPositive);
    if (pattern.kind == Kind::kCosinePower) {
      pattern.exponent = map.required_number("exponent", kNotNegative);
      pattern.half_angle_rad = map.number("half_angle_rad", M_PI / 2, kPositive);
    }
    if (pattern.kind == Kind::kHalfPower) {
      pattern.half_power_angle_rad = map.required_number("half_power_angle_rad", kHalfPowerAngle);
      pattern.half_angle_rad = map.number("half_angle_rad", pattern.half_angle_rad, kPositive);
    }
    if (pattern.kind == Kind::kTable) {
      pattern.angle_rad = map.numbers("angle_rad", 0, kNotNegative);
      pattern.gain = map.numbers("gain", 0, kFraction);
    }
  });
}

void read_scene_beacons(YamlMap& root, Scene& scene, YamlLog& log) {
  root.each("beacons", scene.beacons, [&](YamlMap& map, SceneBeacon& beacon) {
    beacon.name = map.required_text("id");
    beacon.axis = read_axis(map, "[0, 0, -1]", log);
    beacon.pattern = read_pattern_name(map, "pattern", scene);
  });
}

void read_routes(YamlMap& root, Scene& scene, YamlLog& log) {
  root.each("routes", scene.routes, [&](YamlMap& map, SceneRoute& route) {
    route.name = id_of(map, "R", scene.routes.size());
    route.points_m = required_points(map, log);
  });
}

void read_acoustics(YamlMap& root, Scene& scene, YamlLog& log) {
  YamlMap map(root.block("acoustics"), root.path("acoustics"), log);
  SceneAcoustics& a = scene.acoustics;
  a.frequency_hz = map.optional_number("frequency_hz", kPositive);
  a.absorption_np_per_m = map.optional_number("absorption_np_per_m", kNotNegative);
  a.amplitude_1m_v = map.optional_number("amplitude_1m_v", kPositive);
  a.threshold_v = map.optional_number("threshold_v", kPositive);
  a.range_m = map.optional_number("range_m", kPositive);
  map.finish();
  YamlMap noise(root.block("noise"), root.path("noise"), log);
  scene.noise.sigma_m_per_m = noise.number("sigma_m_per_m", 0.0, kNotNegative);
  scene.noise.sigma_m_per_sqrt_m = noise.number("sigma_m_per_sqrt_m", 0.0, kNotNegative);
  noise.finish();
}

std::string beside(const std::string& file, const std::string& path) {
  const std::filesystem::path given(path);
  return given.is_absolute() ? path : (std::filesystem::path(file).parent_path() / given).string();
}

std::vector<std::string> read_layers(YamlMap& map, const char* key, YamlLog& log) {
  std::vector<std::string> layers;
  for (const YamlNode& item : map.list(key)) layers.push_back(text_of(item, map.path(key), log));
  return layers;
}

bool among(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

std::optional<Error> import_dxf(YamlMap& map, Scene& scene, YamlLog& log) {
  const std::string file = map.required_text("dxf");
  const auto unit_m = map.optional_number("unit_m", kPositive);
  const double bottom_m = map.number("bottom_m", 0.0),
               top_m = map.optional_number("top_m").value_or(std::numeric_limits<double>::infinity());
  const std::vector<std::string> layers = read_layers(map, "layers", log),
                                 solid = read_layers(map, "obstacle_layers", log);
  const std::string floor = map.text("floor_layer", "");
  map.finish();
  if (log.error) return log.error;
  scene.imported.push_back(beside(log.file, file));
  const auto drawing = read_dxf(scene.imported.back(), unit_m);
  if (!drawing) return drawing.error();
  scene.warnings.insert(scene.warnings.end(), drawing->warnings.begin(), drawing->warnings.end());
  std::size_t taken = 0;
  for (const DrawnLine& line : drawing->lines) {
    if (!floor.empty() && line.layer == floor) {
      scene.floor_m = line.points_m, scene.floor_line = map.node().line();
      ++taken;
      continue;
    }
    SceneWall wall;
    wall.solid = line.closed && among(solid, line.layer);
    if (!wall.solid && !layers.empty() && !among(layers, line.layer)) continue;
    wall.name = fmt::format("{}:{}", file, line.line);
    wall.points_m = line.points_m;
    if (line.closed && !wall.solid) wall.points_m.push_back(line.points_m.front());
    wall.bottom_m = bottom_m, wall.top_m = top_m;
    wall.line = map.node().line();
    scene.walls.push_back(std::move(wall));
    ++taken;
  }
  if (taken == 0) {
    std::vector<std::string> names;
    for (const DrawnLine& line : drawing->lines)
      if (!among(names, line.layer)) names.push_back(line.layer);
    return Error{.file = log.file,
                 .line = map.node().line(),
                 .found = fmt::format("{} gives not a single line", in_quotes(file)),
                 .expected = "LINE, LWPOLYLINE or POLYLINE in the layers asked for",
                 .advice = names.empty() ? "" : "its layers: " + listed(names)};
  }
  return std::nullopt;
}

std::optional<Error> import_ros(YamlMap& map, Scene& scene, YamlLog& log) {
  const std::string file = map.required_text("ros_map");
  const double bottom_m = map.number("bottom_m", 0.0),
               top_m = map.optional_number("top_m").value_or(std::numeric_limits<double>::infinity());
  map.finish();
  if (log.error) return log.error;
  const auto ros = read_ros_map(beside(log.file, file));
  if (!ros) return ros.error();
  scene.imported.insert(scene.imported.end(), {beside(log.file, file), ros->image});
  for (const auto kind : {RosMap::kOccupied, RosMap::kUnknown}) {
    std::size_t index = 0;
    for (auto& corners : rectangles_of(*ros, kind)) {
      SceneWall wall;
      wall.name = fmt::format("{}:{}{}", file, kind == RosMap::kOccupied ? "occupied" : "unknown", index++);
      wall.points_m = std::move(corners);
      wall.solid = true;
      wall.blocks_sound = kind == RosMap::kOccupied;
      wall.bottom_m = bottom_m, wall.top_m = top_m;
      wall.slack_m = kind == RosMap::kOccupied ? kImportedSlack * ros->resolution_m : 1e300;
      wall.line = map.node().line();
      scene.walls.push_back(std::move(wall));
    }
  }
  if (scene.floor_m.empty()) {
    const auto c = static_cast<double>(ros->columns), r = static_cast<double>(ros->rows);
    scene.floor_m = {ros->place_m(0, 0), ros->place_m(c, 0), ros->place_m(c, r), ros->place_m(0, r)};
    scene.floor_line = map.node().line();
  }
  return std::nullopt;
}

void read_imports(YamlMap& root, Scene& scene, YamlLog& log) {
  std::size_t index = 0;
  for (const YamlNode& node : root.list("import")) {
    if (log.error) return;
    YamlMap map(node, fmt::format("{}[{}]", root.path("import"), index++), log);
    if (map.has("dxf") == map.has("ros_map")) {
      log.fail(node, map.name() + " names no plan, or two", "{dxf: FILE} or {ros_map: FILE.yaml}");
      return;
    }
    const auto error = map.has("dxf") ? import_dxf(map, scene, log) : import_ros(map, scene, log);
    if (error && !log.error) log.error = error;
  }
}

void read_block(YamlMap& root, Scene& scene, YamlLog& log) {
  if (const YamlNode floor = root.block("floor_m"); floor.is_defined()) {
    scene.floor_m = points_of<2>(floor, root.path("floor_m"), log);
    scene.floor_line = floor.line();
  }
  read_walls(root, "walls", false, scene, log);
  read_walls(root, "obstacles", true, scene, log);
  read_mounts(root, scene, log);
  read_patterns(root, scene);
  scene.beacon_pattern = read_pattern_name(root, "beacon_pattern", scene);
  scene.receiver_pattern = read_pattern_name(root, "receiver_pattern", scene);
  read_scene_beacons(root, scene, log);
  read_routes(root, scene, log);
  read_acoustics(root, scene, log);
  const YamlNode cell = root.get("cell_m");
  scene.cell_line = cell.is_defined() ? cell.line() : root.node().line();
  scene.cell_m =
      root.number("cell_m", scene.cell_m,
                  {.low = 0.0, .low_excluded = true, .words = "a positive size in metres, such as 0.25"});
  scene.headings = root.integer("headings", scene.headings, 1, 360);
  scene.vehicle_z_m = root.number("vehicle_z_m", 0.0);
  scene.temperature_error_degC = root.number("temperature_error_degC", scene.temperature_error_degC);
  scene.coverage = root.integer("coverage", 0, 0, 1000);
  read_imports(root, scene, log);
  root.finish();
}

Result<Scene> scene_of(const YamlNode& node, const char* name, const std::string& file) {
  YamlLog log(file);
  Scene scene;
  scene.path = file;
  YamlMap root(node, name, log);
  if (*name == '\0') check_version(root, "octant_scene", log);
  if (!log.error) read_block(root, scene, log);
  if (log.error) return fail(*log.error);
  scene.warnings.insert(scene.warnings.begin(), log.warnings.begin(), log.warnings.end());
  return scene;
}

}  // namespace

Result<std::optional<Scene>> read_site_scene(const std::string& site_path) {
  const auto root = read_yaml(site_path);
  if (!root) return fail(root.error());
  YamlLog log(site_path);
  YamlMap map(*root, "", log);
  const YamlNode block = map.block("scene");
  if (log.error) return fail(*log.error);
  if (!block.is_defined()) return std::optional<Scene>();
  return scene_of(block, "scene", site_path).map([](Scene&& scene) {
    return std::optional(std::move(scene));
  });
}

Result<Scene> read_scene(const std::string& path) {
  return read_yaml(path).and_then([&path](const YamlNode& root) { return scene_of(root, "", path); });
}

}  // namespace octant::io
