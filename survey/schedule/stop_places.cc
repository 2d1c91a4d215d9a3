// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/schedule/stop_places.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "models/physics/polygon.h"

namespace octant::survey {
namespace {

constexpr double kUsualPlaces = 120;
constexpr double kMostPlaces = 2e5;

}  // namespace

Result<StopPlaces> stop_places(const SurveyModel& model, const Scene& scene, double spacing_m,
                               double clearance_m) {
  StopPlaces stops;
  const double area_m2 = std::abs(signed_area_m2(model.floor_m));
  stops.spacing_m = spacing_m > 0 ? spacing_m : std::max(1.0, std::sqrt(area_m2 / kUsualPlaces));
  std::vector<Polygon> in_the_way;
  for (const SceneWall& wall : scene.walls)
    if (wall.solid && wall.blocks_vehicle) in_the_way.push_back(wall.points_m);
  stops.may_stop = [floor = model.floor_m, in_the_way, clearance_m](const Eigen::Vector2d& p) {
    if (!is_inside(floor, p) || distance_to_outline_m(floor, p) < clearance_m) return false;
    return std::ranges::none_of(in_the_way, [&](const Polygon& o) {
      return is_inside(o, p) || distance_to_outline_m(o, p) < clearance_m;
    });
  };
  const Eigen::AlignedBox2d box = bounds_of(model.floor_m);
  const Eigen::Vector2d size = box.sizes();
  if (!(size.x() * size.y() / (stops.spacing_m * stops.spacing_m) <= kMostPlaces))
    return fail({.file = scene.path,
                 .found = fmt::format("a grid of {:g} m makes {:.3g} places", stops.spacing_m,
                                      size.x() * size.y() / (stops.spacing_m * stops.spacing_m)),
                 .expected = fmt::format("{:.0e} places at most", kMostPlaces),
                 .advice = "a wider grid: stops are shifted between its places anyway"});
  // Middles of equal cells, so that the places are as far from both edges.
  const Eigen::Array2d count = (size / stops.spacing_m).array().ceil().max(1.0), step = size.array() / count;
  for (double i = 0; i < count.x(); ++i)
    for (double j = 0; j < count.y(); ++j) {
      const Eigen::Vector2d p = box.min().array() + step * (Eigen::Array2d(i, j) + 0.5);
      if (stops.may_stop(p)) stops.places_m.push_back(p);
    }
  if (stops.places_m.empty())
    return fail({.file = scene.path,
                 .found = fmt::format("no place on the floor is {:g} m from its edge and from obstacles",
                                      clearance_m),
                 .expected = "room for the vehicle",
                 .advice = "a smaller clearance or grid"});
  return stops;
}

}  // namespace octant::survey
