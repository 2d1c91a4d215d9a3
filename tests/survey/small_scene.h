// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/physics/receiver_array.h"
#include "survey/map/survey.h"
#include "tests/support/worlds.h"

namespace octant::test {

/// A hall with a column in the middle and a curtain.
inline Scene small_scene() {
  Scene scene;
  scene.floor_m = {{0, 0}, {12, 0}, {12, 8}, {0, 8}};
  scene.cell_m = 0.5;
  SceneWall column{.name = "column", .points_m = {{5, 3}, {7, 3}, {7, 5}, {5, 5}}, .solid = true};
  SceneWall curtain{.name = "curtain", .points_m = {{9, 0}, {9, 4}}, .top_m = 2.0};
  scene.walls = {column, curtain};
  scene.routes = {{"way", {{1, 1}, {11, 1}, {11, 7}}, 0}};
  return scene;
}

inline Site small_site(int beacons = 7) {
  Site site;
  site.name = "small";
  site.medium = {.model = MediumModel::kCramer1993};
  site.noise.tof_sigma_s = 1e-5;
  const double places[8][3] = {{0, 0, 2.5}, {6, 0, 2.6}, {12, 0, 2.4}, {12, 8, 2.7},
                               {6, 8, 2.5}, {0, 8, 2.4}, {0, 4, 2.6},  {12, 4, 2.5}};
  for (int i = 0; i < beacons; ++i)
    site.beacons.push_back(beacon("B" + std::to_string(i), {places[i][0], places[i][1], places[i][2]}, 0.0));
  add_octagon(site);
  site.tolerance.fix_m = 0.003;
  return site;
}

}  // namespace octant::test
