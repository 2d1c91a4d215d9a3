// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/placement/mounts.h"

#include <algorithm>
#include <cmath>

#include "models/physics/polygon.h"

namespace octant::survey {
namespace {

constexpr double kStandoffM =
    0.02;                       ///< a beacon's face before its wall, so that the wall is not in its own way
constexpr double kPoleM = 1.0;  ///< length of a wall to which a pole is equivalent
constexpr double kHigher = 1e-6;

}  // namespace

Result<MountSpace> MountSpace::of(const Scene& scene) {
  MountSpace space;
  for (const SceneMount& mount : scene.mounts) space.add(mount);
  if (space.pieces_.empty() || !(space.length_m_ > 0))
    return fail({.file = scene.path,
                 .found = "the scene says nowhere where beacons may be mounted",
                 .expected = "scene.mounts: walls, ceilings or poles",
                 .advice = "add a mounts list to the scene block"});
  double end = 0.0;
  for (const Piece& piece : space.pieces_) {
    end += piece.length_m / space.length_m_;
    space.ends_.push_back(end);
    space.wide_ =
        space.wide_ || piece.kind == SceneMount::Kind::kCeiling || piece.high_m > piece.low_m + kHigher;
  }
  space.ends_.back() = 1.0;
  if (scene.beacon_pattern) space.pattern_ = *scene.beacon_pattern;
  return space;
}

void MountSpace::add(const SceneMount& mount) {
  Piece piece;
  piece.name = mount.name;
  piece.kind = mount.kind;
  piece.low_m = mount.low_m;
  piece.high_m = mount.high_m;
  const auto push = [&](const Eigen::Vector3d& usual_axis) {
    piece.axis = mount.axis ? mount.axis->normalized() : usual_axis;
    length_m_ += piece.length_m;
    if (piece.kind == SceneMount::Kind::kCeiling) ceiling_m_ += piece.length_m;
    pieces_.push_back(piece);
  };
  if (mount.kind == SceneMount::Kind::kWall) {
    for (std::size_t i = 0; i + 1 < mount.points_m.size(); ++i) {
      piece.points_m = {mount.points_m[i], mount.points_m[i + 1]};
      const Eigen::Vector2d along = piece.points_m[1] - piece.points_m[0];
      piece.length_m = along.norm();
      if (piece.length_m > 0) push(Eigen::Vector3d(-along.y(), along.x(), 0.0) / piece.length_m);
    }
    return;
  }
  piece.points_m = mount.points_m;
  piece.length_m = kPoleM;
  if (mount.kind == SceneMount::Kind::kPole) {
    push(Eigen::Vector3d::Zero());
    return;
  }
  piece.box = bounds_of(piece.points_m);
  piece.length_m = 2 * piece.box.sizes().sum();  // as the walls round it
  push(-Eigen::Vector3d::UnitZ());
}

std::size_t MountSpace::piece_of(double along) const {
  const auto at = std::ranges::upper_bound(ends_, along);
  return std::min(static_cast<std::size_t>(at - ends_.begin()), pieces_.size() - 1);
}

SurveyBeacon MountSpace::beacon(const MountPoint& point) const {
  const double along = std::clamp(point.along, 0.0, 1.0), across = std::clamp(point.across, 0.0, 1.0);
  const std::size_t i = piece_of(along);
  const Piece& piece = pieces_[i];
  const double begin = i == 0 ? 0.0 : ends_[i - 1],
               part = std::clamp((along - begin) / (ends_[i] - begin), 0.0, 1.0);
  SurveyBeacon beacon;
  beacon.axis = piece.axis;
  beacon.pattern = piece.axis.isZero() ? kAllRound : pattern_;
  if (piece.kind == SceneMount::Kind::kCeiling) {
    const Eigen::Vector2d at =
        piece.box.min() + Eigen::Vector2d(part, across).cwiseProduct(piece.box.sizes());
    beacon.p_map_m << (is_inside(piece.points_m, at) ? at : nearest_on_outline(piece.points_m, at)),
        piece.high_m;
    return beacon;
  }
  Eigen::Vector2d at = piece.points_m.front();
  if (piece.kind == SceneMount::Kind::kWall) {
    const Eigen::Vector2d run = piece.points_m[1] - piece.points_m[0];
    at += part * run + kStandoffM * Eigen::Vector2d(-run.y(), run.x()).normalized();
  }
  beacon.p_map_m << at, piece.low_m + across * (piece.high_m - piece.low_m);
  return beacon;
}

MountLayout MountSpace::grid(std::size_t count) const {
  MountLayout points;
  const double step_m = length_m_ / static_cast<double>(std::max<std::size_t>(count, 1));
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    const double begin = i == 0 ? 0.0 : ends_[i - 1], share = ends_[i] - begin;
    auto along = static_cast<std::size_t>(std::ceil(piece.length_m / step_m));
    std::vector<double> across = {0.5};
    if (piece.kind == SceneMount::Kind::kCeiling) {
      // Number of positions by the share of the perimeter, in two dimensions.
      const Eigen::Vector2d size = piece.box.sizes();
      const double side_m = std::sqrt(std::max(size.x() * size.y(), 1e-9) / static_cast<double>(along));
      along = static_cast<std::size_t>(std::max(1.0, std::round(size.x() / side_m)));
      const auto rows = static_cast<std::size_t>(std::max(1.0, std::round(size.y() / side_m)));
      across.clear();
      for (std::size_t r = 0; r < rows; ++r)
        across.push_back((static_cast<double>(r) + 0.5) / static_cast<double>(rows));
    } else if (piece.high_m > piece.low_m + kHigher) {
      across = {0.0, 0.5, 1.0};
    }
    if (piece.kind == SceneMount::Kind::kPole) along = 1;
    for (std::size_t k = 0; k < along; ++k)
      for (const double v : across)
        points.push_back({begin + share * (static_cast<double>(k) + 0.5) / static_cast<double>(along), v});
  }
  return points;
}

MountLayout MountSpace::regular(std::size_t count, double phase) const {
  MountLayout points;
  const auto n = static_cast<double>(count);
  if (2 * ceiling_m_ <= length_m_) {
    for (std::size_t k = 0; k < count; ++k)
      points.push_back({std::fmod((static_cast<double>(k) + phase) / n, 1.0), 0.5});
    return points;
  }
  // The largest ceiling, in rows as square as the number allows; the last row takes what is left.
  std::size_t largest = 0;
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    if (pieces_[i].kind == SceneMount::Kind::kCeiling && pieces_[i].length_m > pieces_[largest].length_m)
      largest = i;
  const Piece& piece = pieces_[largest];
  const double begin = largest == 0 ? 0.0 : ends_[largest - 1], share = ends_[largest] - begin;
  const Eigen::Vector2d size = piece.box.sizes();
  const auto rows = static_cast<std::size_t>(
      std::clamp(std::round(std::sqrt(n * size.y() / std::max(size.x(), 1e-9))), 1.0, n));
  for (std::size_t r = 0, placed = 0; r < rows; ++r) {
    const std::size_t columns = (count - placed) / (rows - r);
    for (std::size_t c = 0; c < columns; ++c)
      points.push_back(
          {begin + share * std::fmod((static_cast<double>(c) + phase) / static_cast<double>(columns), 1.0),
           (static_cast<double>(r) + 0.5) / static_cast<double>(rows)});
    placed += columns;
  }
  return points;
}

MountLayout MountSpace::random(std::size_t count, Random& draws) const {
  MountLayout points;
  for (std::size_t k = 0; k < count; ++k) {
    const double along = draws.uniform();
    points.push_back({along, draws.uniform()});
  }
  return points;
}

}  // namespace octant::survey
