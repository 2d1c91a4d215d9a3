// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/scene_check.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "models/physics/polygon.h"

namespace octant::survey {
namespace {

using Points = std::vector<Eigen::Vector2d>;
constexpr std::size_t kMostCorners = 20000;  ///< each side is compared with each other

tl::unexpected<Error> bad(const Scene& scene, int line, std::string found, std::string expected,
                          std::string advice = "") {
  return fail({.file = scene.path,
               .line = line,
               .found = std::move(found),
               .expected = std::move(expected),
               .advice = std::move(advice)});
}

std::string at(const Eigen::Vector2d& p) { return fmt::format("({:.10g}, {:.10g})", p.x(), p.y()); }

bool finite(const Points& points) {
  return std::ranges::all_of(points, [](const Eigen::Vector2d& p) { return p.allFinite(); });
}

Result<void> check_outline(const Scene& scene, const std::string& name, const Points& points, int line) {
  if (points.size() < 3)
    return bad(scene, line, fmt::format("{} has {} corners", name, points.size()), "three at least");
  if (points.size() > kMostCorners)
    return bad(scene, line, fmt::format("{} has {} corners", name, points.size()),
               fmt::format("{} at most", kMostCorners));
  if (!finite(points)) return bad(scene, line, name + " has a corner that is no finite number", "numbers");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i] == points[(i + 1) % points.size()])
      return bad(scene, line,
                 fmt::format("{} has the corner {} twice in a row{}", name, at(points[i]),
                             i + 1 < points.size() ? "" : ", at its end and its begin"),
                 "each corner once; an outline closes by itself");
  if (const auto cross = self_crossing(points)) {
    const auto side = [&](std::size_t i) {
      return fmt::format("the side from {} to {}", at(points[i]), at(points[(i + 1) % points.size()]));
    };
    return bad(scene, line,
               fmt::format("{} crosses itself: {} and {}", name, side(cross->first), side(cross->second)),
               "corners in order round the outline");
  }
  if (!(std::abs(signed_area_m2(points)) > 1e-12))
    return bad(scene, line, name + " has no area", "corners that enclose an area");
  return {};
}

Result<void> check_line(const Scene& scene, const std::string& name, const Points& points, int line) {
  if (points.size() < 2)
    return bad(scene, line, fmt::format("{} has {} points", name, points.size()), "two at least");
  if (!finite(points)) return bad(scene, line, name + " has a point that is no finite number", "numbers");
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i] == points[i - 1])
      return bad(scene, line, fmt::format("{} has the point {} twice in a row", name, at(points[i])),
                 "each point once");
  return {};
}

Result<void> check_walls(const Scene& scene) {
  for (const SceneWall& wall : scene.walls) {
    const std::string name = fmt::format("{} '{}'", wall.solid ? "obstacle" : "wall", wall.name);
    const auto checked = wall.solid ? check_outline(scene, name, wall.points_m, wall.line)
                                    : check_line(scene, name, wall.points_m, wall.line);
    if (!checked) return checked;
    if (!(wall.top_m > wall.bottom_m))
      return bad(scene, wall.line,
                 fmt::format("{} ends at {:g} m, below its begin at {:g} m", name, wall.top_m, wall.bottom_m),
                 "a height above its bottom");
  }
  return {};
}

Result<void> check_mounts(const Scene& scene) {
  for (const SceneMount& mount : scene.mounts) {
    const std::string name = fmt::format("mount '{}'", mount.name);
    if (mount.kind == SceneMount::Kind::kPole) {
      if (mount.points_m.size() != 1 || !finite(mount.points_m))
        return bad(scene, mount.line, name + " is a pole", "one point");
    } else {
      const auto checked = mount.kind == SceneMount::Kind::kWall
                               ? check_line(scene, name, mount.points_m, mount.line)
                               : check_outline(scene, name, mount.points_m, mount.line);
      if (!checked) return checked;
    }
    if (!std::isfinite(mount.low_m) || !std::isfinite(mount.high_m))
      return bad(scene, mount.line, name + " has a height that is no finite number", "numbers");
    if (!(mount.high_m >= mount.low_m))
      return bad(scene, mount.line,
                 fmt::format("{} reaches from {:g} m down to {:g} m", name, mount.low_m, mount.high_m),
                 "the lower height first");
  }
  return {};
}

Result<void> check_patterns(const Scene& scene) {
  for (const BeamPattern& p : scene.patterns) {
    const std::string name = fmt::format("pattern '{}'", p.name);
    if (p.kind != BeamPattern::Kind::kTable) {
      if (!(p.half_angle_rad > 0))
        return bad(scene, p.line, name + " hears nothing", "a positive half_angle_rad");
      if (!(p.exponent >= 0))
        return bad(scene, p.line, name + " has a negative exponent", "zero or a positive number");
      continue;
    }
    if (p.angle_rad.size() < 2 || p.angle_rad.size() != p.gain.size())
      return bad(scene, p.line,
                 fmt::format("{} has {} angles and {} gains", name, p.angle_rad.size(), p.gain.size()),
                 "as many of one as of the other, two at least");
    for (std::size_t i = 0; i < p.gain.size(); ++i) {
      if (!(p.gain[i] >= 0 && p.gain[i] <= 1))
        return bad(scene, p.line, fmt::format("{} has a gain of {:g}", name, p.gain[i]), "gains from 0 to 1");
      if (i == 0 ? p.angle_rad[0] != 0 : !(p.angle_rad[i] > p.angle_rad[i - 1]))
        return bad(scene, p.line, name + " has angles out of order", "angles that rise from 0");
    }
  }
  return {};
}

Result<void> check_routes(const Scene& scene) {
  for (const SceneRoute& route : scene.routes) {
    const std::string name = fmt::format("route '{}'", route.name);
    if (const auto checked = check_line(scene, name, route.points_m, route.line); !checked) return checked;
    for (const Eigen::Vector2d& p : route.points_m) {
      if (!scene.floor_m.empty() && !is_inside(scene.floor_m, p) &&
          distance_to_outline_m(scene.floor_m, p) > 1e-6)
        return bad(scene, route.line, fmt::format("{} leaves the floor at {}", name, at(p)),
                   "points on the floor");
      for (const SceneWall& wall : scene.walls)
        if (wall.solid && wall.blocks_vehicle && is_inside(wall.points_m, p) &&
            distance_to_outline_m(wall.points_m, p) > wall.slack_m + 1e-6)
          return bad(scene, route.line,
                     fmt::format("{} runs through obstacle '{}' at {}", name, wall.name, at(p)),
                     "points where a vehicle can be");
    }
  }
  return {};
}

}  // namespace

Result<void> check_scene(const Scene& scene) {
  if (!(scene.cell_m > 0) || !std::isfinite(scene.cell_m))
    return bad(scene, scene.cell_line, fmt::format("cell_m is {:g}", scene.cell_m),
               "a positive size in metres, such as 0.25");
  if (!scene.floor_m.empty())
    if (const auto checked = check_outline(scene, "the floor", scene.floor_m, scene.floor_line); !checked)
      return checked;
  for (const auto check : {check_walls, check_mounts, check_patterns, check_routes})
    if (const auto checked = check(scene); !checked) return checked;
  return {};
}

Result<void> check_beacon_places(const Scene& scene, const SurveyModel& model,
                                 const std::vector<double>& sigma_m) {
  for (std::size_t b = 0; b < model.beacons.size(); ++b) {
    const SurveyBeacon& beacon = model.beacons[b];
    const Eigen::Vector2d p = beacon.p_map_m.head<2>();
    const double room_m = kOutside_m + 3 * (b < sigma_m.size() ? sigma_m[b] : 0.0);
    int line = 0;
    for (const SceneBeacon& other : scene.beacons)
      if (other.name == beacon.name) line = other.line;
    if (!scene.floor_m.empty() && !is_inside(scene.floor_m, p) &&
        distance_to_outline_m(scene.floor_m, p) > room_m)
      return bad(scene, line,
                 fmt::format("beacon '{}' at {} is {:.2f} m outside the floor", beacon.name, at(p),
                             distance_to_outline_m(scene.floor_m, p)),
                 "beacons within the floor's outline", "correct the beacon's position or the outline");
    for (const SceneWall& wall : scene.walls) {
      if (!wall.solid || beacon.p_map_m.z() < wall.bottom_m || beacon.p_map_m.z() > wall.top_m ||
          !is_inside(wall.points_m, p))
        continue;
      const double deep_m = distance_to_outline_m(wall.points_m, p);
      if (deep_m > wall.slack_m + 3 * (b < sigma_m.size() ? sigma_m[b] : 0.0) + 1e-3)
        return bad(scene, line > 0 ? line : wall.line,
                   fmt::format("beacon '{}' at {} is {:.2f} m inside obstacle '{}'", beacon.name, at(p),
                               deep_m, wall.name),
                   "a beacon in the open, or on a face",
                   "correct the beacon's position, or the obstacle's corners or heights");
    }
  }
  return {};
}

}  // namespace octant::survey
