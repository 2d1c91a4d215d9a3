// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/map_tiles.h"
#include "models/physics/plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace octant::survey {
namespace {

using Eigen::Vector2d;

/// Extent of a tile's receivers.
struct TileBox {
  Vector2d low = Vector2d::Constant(1e300), high = Vector2d::Constant(-1e300);
  double bottom_m = 1e300, top_m = -1e300;
  [[nodiscard]] std::array<Vector2d, 4> corners() const {
    return {low, Vector2d(high.x(), low.y()), high, Vector2d(low.x(), high.y())};
  }
};

KernelTransducer transducer(const Eigen::Vector3d& p, const Eigen::Vector3d& axis, std::size_t pattern,
                            const SurveyModel& model, const std::vector<std::vector<double>>& gains) {
  KernelTransducer t;
  for (int i = 0; i < 3; ++i) t.p_m[i] = p[i], t.axis[i] = axis[i];
  if (pattern == kAllRound || axis.isZero()) return t;
  const BeamPattern& beam = model.patterns[pattern];
  const double widest =
      beam.kind == BeamPattern::Kind::kTable
          ? (beam.angle_rad.empty() ? 0.0 : beam.angle_rad.back())
          : std::min(beam.half_angle_rad,
                     beam.kind == BeamPattern::Kind::kCosinePower ? std::numbers::pi / 2 : 4.0);
  if (beam.kind == BeamPattern::Kind::kCone && widest >= std::numbers::pi) return t;
  t.least_cosine = widest >= std::numbers::pi ? -1.5 : std::cos(widest);
  if (beam.kind != BeamPattern::Kind::kCone) t.gain = gains[pattern].data();
  return t;
}

TileBox box_of(const KernelModel& kernel, const KernelTile& tile) {
  double lever = 0.0, low = 1e300, high = -1e300;
  for (const KernelTransducer& r : kernel.receivers) {
    lever = std::max(lever, std::hypot(r.p_m[0], r.p_m[1]));
    low = std::min(low, r.p_m[2]), high = std::max(high, r.p_m[2]);
  }
  TileBox box;
  for (std::size_t i = 0; i < tile.count; ++i) {
    const Vector2d at(tile.x_m[i], tile.y_m[i]);
    box.low = box.low.cwiseMin(at), box.high = box.high.cwiseMax(at);
    box.bottom_m = std::min(box.bottom_m, tile.z_m[i] + low),
    box.top_m = std::max(box.top_m, tile.z_m[i] + high);
  }
  // Slightly larger, so that rounding excludes no path.
  const double room = lever + 1e-9 * (1.0 + box.low.cwiseAbs().maxCoeff() + box.high.cwiseAbs().maxCoeff());
  box.low.array() -= room, box.high.array() += room;
  return box;
}

double distance_m(const TileBox& box, const KernelTransducer& beacon) {
  const Vector2d b(beacon.p_m[0], beacon.p_m[1]);
  const Vector2d gap = (box.low - b).cwiseMax(b - box.high).cwiseMax(0.0);
  const double dz = std::max({0.0, box.bottom_m - beacon.p_m[2], beacon.p_m[2] - box.top_m});
  return std::hypot(gap.x(), gap.y(), dz);
}

/// A line separates the wall from all paths between beacon and box: the wall's own, the sides of the box, or
/// one through the beacon that touches the box.
bool cannot_stand_between(const WallPiece& wall, const Vector2d& beacon,
                          const std::array<Vector2d, 4>& corners, const TileBox& box) {
  const Vector2d low = box.low.cwiseMin(beacon), high = box.high.cwiseMax(beacon);
  if ((wall.from_m.cwiseMax(wall.to_m).array() < low.array()).any() ||
      (wall.from_m.cwiseMin(wall.to_m).array() > high.array()).any())
    return true;
  const Vector2d along = wall.to_m - wall.from_m;
  double least = cross(along, beacon - wall.from_m), most = least;
  for (const Vector2d& c : corners) {
    const double side = cross(along, c - wall.from_m);
    least = std::min(least, side), most = std::max(most, side);
  }
  if (least > 0 || most < 0) return true;
  for (const Vector2d& c : corners) {
    const Vector2d ray = c - beacon;
    double right = 0.0, left = 0.0;
    for (const Vector2d& other : corners) {
      const double side = cross(ray, other - beacon);
      right = std::min(right, side), left = std::max(left, side);
    }
    const double from = cross(ray, wall.from_m - beacon), to = cross(ray, wall.to_m - beacon);
    if (right >= 0 && from < 0 && to < 0) return true;
    if (left <= 0 && from > 0 && to > 0) return true;
  }
  return false;
}

/// The region that a piece of wall hides from a beacon is convex: if it contains all corners of the room, it
/// contains the room.
bool hides(const WallPiece& wall, const KernelTransducer& beacon, const std::array<Vector2d, 4>& corners,
           const TileBox& box) {
  const Vector2d b(beacon.p_m[0], beacon.p_m[1]), along = wall.to_m - wall.from_m;
  const double sb = cross(along, b - wall.from_m);
  for (const Vector2d& c : corners) {
    const double sc = cross(along, c - wall.from_m);
    const double from = cross(b - c, wall.from_m - c), to = cross(b - c, wall.to_m - c);
    if (!(sc * sb < 0 && from * to < 0)) return false;
    const double part = sc / (sc - sb);
    for (const double z : {box.bottom_m, box.top_m}) {
      const double crossing = z + part * (beacon.p_m[2] - z);
      if (!(crossing > wall.bottom_m && crossing < wall.top_m)) return false;
    }
  }
  return true;
}

}  // namespace

KernelModel kernel_model(const SurveyModel& model, const std::vector<SurveyBeacon>& beacons) {
  KernelModel kernel;
  kernel.unknowns = model.unknowns;
  for (const BeamPattern& pattern : model.patterns) {
    std::vector<double>& gains = kernel.gains.emplace_back(kGainSteps + 1);
    for (std::size_t i = 0; i <= kGainSteps; ++i)
      gains[i] = beam_gain(pattern, -1.0 + 2.0 * static_cast<double>(i) / kGainSteps);
  }
  for (const SurveyBeacon& b : beacons)
    kernel.beacons.push_back(transducer(b.p_map_m, b.axis, b.pattern, model, kernel.gains));
  for (const SurveyReceiver& r : model.receivers)
    kernel.receivers.push_back(transducer(r.p_vehicle_m, r.axis, r.pattern, model, kernel.gains));
  kernel.reach_m = reach_m(model.hearing);
  kernel.amplitude_1m_v = model.hearing.amplitude_1m_v;
  kernel.threshold_v = model.hearing.threshold_v;
  kernel.absorption_np_per_m = model.hearing.absorption_np_per_m;
  kernel.constant_m2 = model.noise.constant_m * model.noise.constant_m;
  kernel.per_m2 = model.noise.per_m * model.noise.per_m;
  kernel.per_sqrt_m2 = model.noise.per_sqrt_m * model.noise.per_sqrt_m;
  return kernel;
}

void fill_tile(const KernelModel& kernel, const std::vector<WallPiece>& walls, const PoseList& poses,
               std::size_t first, std::size_t count, KernelTile& tile) {
  tile.count = count;
  const std::size_t padded = (count + kMapLanes - 1) / kMapLanes * kMapLanes;
  double heading = 0.0, cosine = 1.0, sine = 0.0;
  for (std::size_t i = 0; i < padded; ++i) {
    const std::size_t from = first + std::min(i, count - 1);
    if (poses.heading_rad[from] != heading)
      heading = poses.heading_rad[from], cosine = std::cos(heading), sine = std::sin(heading);
    tile.x_m[i] = poses.x_m[from], tile.y_m[i] = poses.y_m[from], tile.z_m[i] = poses.z_m[from];
    tile.cosine[i] = cosine, tile.sine[i] = sine;
  }
  const TileBox box = box_of(kernel, tile);
  const auto corners = box.corners();
  tile.walls.clear();
  tile.wall_first.assign(1, 0);
  tile.skip.assign(kernel.beacons.size(), 0);
  for (std::size_t b = 0; b < kernel.beacons.size(); ++b) {
    const KernelTransducer& beacon = kernel.beacons[b];
    const Vector2d at(beacon.p_m[0], beacon.p_m[1]);
    const double bottom = std::min(box.bottom_m, beacon.p_m[2]), top = std::max(box.top_m, beacon.p_m[2]);
    tile.skip[b] = distance_m(box, beacon) > kernel.reach_m;
    for (std::size_t w = 0; w < walls.size() && !tile.skip[b]; ++w) {
      const WallPiece& wall = walls[w];
      if (wall.bottom_m > top || wall.top_m < bottom || cannot_stand_between(wall, at, corners, box))
        continue;
      tile.skip[b] = hides(wall, beacon, corners, box);
      const Vector2d along = wall.to_m - wall.from_m;
      tile.walls.push_back({wall.from_m.x(), wall.from_m.y(), along.x(), along.y(), wall.bottom_m, wall.top_m,
                            wall.bottom_m <= bottom && wall.top_m >= top});
    }
    tile.wall_first.push_back(static_cast<std::uint32_t>(tile.walls.size()));
  }
}

}  // namespace octant::survey
