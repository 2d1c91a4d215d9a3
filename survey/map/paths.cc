// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/paths.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "survey/geometry/hearing.h"

namespace octant::survey {
namespace {

Eigen::Vector3d turned(const Eigen::Vector3d& v, double cosine, double sine) {
  return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y(), v.z()};
}

bool stopped(const KernelWall& w, const Eigen::Vector3d& from, const Eigen::Vector3d& beacon) {
  const double sp = w.wx_m * (from.y() - w.y_m) - w.wy_m * (from.x() - w.x_m),
               sb = w.wx_m * (beacon.y() - w.y_m) - w.wy_m * (beacon.x() - w.x_m);
  const double rx = beacon.x() - from.x(), ry = beacon.y() - from.y();
  const double begin = rx * (w.y_m - from.y()) - ry * (w.x_m - from.x()),
               end = begin + rx * w.wy_m - ry * w.wx_m;
  if (!(sp * sb < 0 && begin * end <= 0)) return false;
  const double z = from.z() + sp / (sp - sb) * (beacon.z() - from.z());
  return w.any_height || (z >= w.bottom_m && z <= w.top_m);
}

}  // namespace

HeardPath path_between(const SurveyModel& model, std::size_t beacon, std::size_t receiver,
                       const PoseAt& pose) {
  const double cosine = std::cos(pose.heading_rad), sine = std::sin(pose.heading_rad);
  const Eigen::Vector3d& lever = model.receivers[receiver].p_vehicle_m;
  const Eigen::Vector3d way = Eigen::Vector3d(pose.x_m, pose.y_m, pose.z_m) + turned(lever, cosine, sine) -
                              model.beacons[beacon].p_map_m;
  HeardPath path;
  path.beacon = beacon, path.receiver = receiver, path.heading_rad = pose.heading_rad;
  path.distance_m = std::max(way.norm(), 1e-6);
  path.unit = way / path.distance_m;
  path.weight = 1.0 / model.noise.variance_m2(path.distance_m);
  const Unknowns& u = model.unknowns;
  path.row.resize(u.count());
  path.row.head(u.position) = path.unit.head(u.position);
  const Eigen::Vector3d by_turn = lever.cross(turned(path.unit, cosine, -sine));
  if (u.rotation == 1) path.row[u.position] = by_turn.z();
  if (u.rotation == 3) path.row.segment<3>(u.position) = by_turn;
  if (u.clock) path.row[u.count() - 1] = 1.0;
  return path;
}

void heard_paths(const SurveyModel& model, const KernelTile& tile, const PoseAt& pose,
                 std::vector<HeardPath>& paths) {
  paths.clear();
  const double cosine = std::cos(pose.heading_rad), sine = std::sin(pose.heading_rad);
  for (std::size_t b = 0; b < model.beacons.size(); ++b) {
    if (tile.skip[b]) continue;
    for (std::size_t r = 0; r < model.receivers.size(); ++r) {
      HeardPath path = path_between(model, b, r, pose);
      if (!loud_enough(model, b, r, path.unit, path.distance_m,
                       turned(model.receivers[r].axis, cosine, sine)))
        continue;
      const Eigen::Vector3d receiver = model.beacons[b].p_map_m + path.distance_m * path.unit;
      bool hidden = false;
      for (std::uint32_t w = tile.wall_first[b]; w < tile.wall_first[b + 1] && !hidden; ++w)
        hidden = stopped(tile.walls[w], receiver, model.beacons[b].p_map_m);
      if (!hidden) paths.push_back(path);
    }
  }
}

}  // namespace octant::survey
