// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Three halls for placement: a rectangle, an L, and a warehouse with aisles. A vehicle with one receiver all
// round; in the first two without a common clock, as in Kleeman's system, in the warehouse with one. Noise
// grows with the distance by a millimetre a metre.

#include <string>
#include <vector>

#include "models/scene.h"
#include "models/site.h"
#include "survey/geometry/survey_model.h"
#include "tests/support/worlds.h"

namespace octant::test {

struct Hall {
  std::string name;
  Site site;
  Scene scene;
};

inline Site one_receiver_site(const std::string& name, double height_m = 0.3) {
  Site site;
  site.name = name;
  site.medium = {.model = MediumModel::kCramer1993, .temperature_degC = 20.0};
  site.noise.tof_sigma_s = 2e-5;
  site.beacons.push_back(beacon("B0", {1.0, 1.0, 2.5}, 0.1));  // somewhere: placement does not look at it
  add_receivers(site, {{0.0, 0.0, height_m}});
  return site;
}

inline SceneMount wall_mount(const std::string& name, const std::vector<Eigen::Vector2d>& points,
                             double low_m, double high_m) {
  SceneMount mount;
  mount.name = name;
  mount.points_m = points;
  mount.low_m = low_m;
  mount.high_m = high_m;
  return mount;
}

inline SceneWall rack(const std::string& name, double x0, double y0, double x1, double y1, double top_m) {
  SceneWall wall;
  wall.name = name;
  wall.points_m = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  wall.solid = true;
  wall.top_m = top_m;
  return wall;
}

/// The outline's walls, which stop sound where the outline is not convex.
inline void add_outline(Hall& hall, const std::vector<Eigen::Vector2d>& corners, double low_m,
                        double high_m) {
  hall.scene.floor_m = corners;
  std::vector<Eigen::Vector2d> closed = corners;
  closed.push_back(corners.front());
  hall.scene.mounts.push_back(wall_mount("walls", closed, low_m, high_m));
  SceneWall wall;
  wall.name = "outline";
  wall.points_m = closed;
  hall.scene.walls.push_back(wall);
}

inline Hall rectangle_hall() {
  Hall hall{"rectangle", one_receiver_site("rectangle"), {}};
  hall.site.timing.clock = Clock::kCycleOffset;
  add_outline(hall, {{0, 0}, {24, 0}, {24, 14}, {0, 14}}, 2.0, 4.0);
  hall.scene.noise.sigma_m_per_m = 1e-3;
  hall.scene.acoustics.range_m = 30.0;
  return hall;
}

inline Hall l_hall() {
  Hall hall{"L-shape", one_receiver_site("L-shape"), {}};
  hall.site.timing.clock = Clock::kCycleOffset;
  add_outline(hall, {{0, 0}, {24, 0}, {24, 9}, {10, 9}, {10, 20}, {0, 20}}, 2.0, 4.0);
  hall.scene.noise.sigma_m_per_m = 1e-3;
  hall.scene.acoustics.range_m = 30.0;
  return hall;
}

/// Three racks of 3 m with aisles of 3.2 m and more between them, beacons under the ceiling at 6 m, the
/// receiver on a forklift's roof, which keeps 0.7 m from the racks.
inline Hall warehouse_hall() {
  Hall hall{"aisles", one_receiver_site("aisles", 2.2), {}};
  const std::vector<Eigen::Vector2d> outline = {{0, 0}, {26, 0}, {26, 16}, {0, 16}};
  hall.scene.floor_m = outline;
  SceneMount ceiling;
  ceiling.name = "ceiling";
  ceiling.kind = SceneMount::Kind::kCeiling;
  ceiling.points_m = outline;
  ceiling.low_m = ceiling.high_m = 6.0;
  hall.scene.mounts.push_back(ceiling);
  for (int i = 0; i < 3; ++i) {
    const double y0 = 3.2 + 4.2 * i, y1 = y0 + 1.2;
    const std::string number = std::to_string(i + 1);
    hall.scene.walls.push_back(rack("rack " + number, 4, y0, 22, y1, 3.0));
    SceneWall keep_off = rack("clearance " + number, 3.3, y0 - 0.7, 22.7, y1 + 0.7, 3.0);
    keep_off.blocks_sound = false;
    hall.scene.walls.push_back(keep_off);
  }
  hall.scene.noise.sigma_m_per_m = 1e-3;
  hall.scene.acoustics.range_m = 30.0;
  return hall;
}

inline std::vector<Hall> three_halls() { return {rectangle_hall(), l_hall(), warehouse_hall()}; }

}  // namespace octant::test
