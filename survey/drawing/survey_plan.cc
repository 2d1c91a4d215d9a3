// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/survey_plan.h"

#include <limits>

#include "survey/drawing/binned_map.h"

namespace octant::survey {
namespace {

NamedMap named_map(const Survey& survey, const FloorMap& map, std::size_t most_bins) {
  const BinnedMap binned = binned_map(survey, map, most_bins);
  const bool length = map.unit == "m";
  const double per_si = length ? 1e3 : 1.0;
  NamedMap named{map.title, length ? "mm" : map.unit, binned.origin_m, binned.bin_m, binned.columns, {}};
  if (binned.against_tolerance) named.tolerance = per_si * *map.limit;
  for (std::size_t i = 0; i < binned.bins.size(); ++i)
    named.values.push_back(binned.bins[i] == BinnedMap::Bin::kValue ? per_si * binned.values[i]
                           : binned.bins[i] == BinnedMap::Bin::kEmpty
                               ? std::numeric_limits<double>::infinity()
                               : std::numeric_limits<double>::quiet_NaN());
  return named;
}

}  // namespace

PlanInput survey_plan(const Survey& survey, const std::vector<const FloorMap*>& maps, std::size_t most_bins) {
  PlanInput plan;
  plan.area_name = "floor", plan.beacon_name = "beacon";
  plan.deployment.site = survey.model.name;
  plan.deployment.validity_area_m = survey.model.floor_m;
  for (const SurveyBeacon& b : survey.model.beacons) {
    DeploymentBeacon& beacon = plan.deployment.beacons.emplace_back();
    beacon.name = b.name;
    beacon.position_m = b.p_map_m;
  }
  for (const SceneWall& wall : survey.scene.walls)
    if (wall.blocks_sound) plan.walls.push_back({wall.name, wall.points_m, wall.solid});
  for (const SceneRoute& route : survey.scene.routes) plan.routes.push_back({route.name, route.points_m});
  for (const FloorMap* map : maps) plan.maps.push_back(named_map(survey, *map, most_bins));
  return plan;
}

}  // namespace octant::survey
