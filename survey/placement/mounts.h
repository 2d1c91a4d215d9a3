// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "models/scene.h"
#include "models/simulator/random.h"
#include "models/support/result.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

/// A place among a scene's mounts in numbers from 0 to 1: `along` runs through all mounts one after the
/// other, by their length; `across` is the height on walls and poles, and the other coordinate of a ceiling.
struct MountPoint {
  double along = 0.0, across = 0.0;
};

using MountLayout = std::vector<MountPoint>;

/// All places where a beacon may be mounted, as one square of numbers.
class MountSpace {
 public:
  /// Errors: the scene has no mounts.
  [[nodiscard]] static Result<MountSpace> of(const Scene& scene);

  /// A beacon there: its place, where it looks, its pattern. On a wall it stands two centimetres before it.
  [[nodiscard]] SurveyBeacon beacon(const MountPoint& point) const;
  [[nodiscard]] const std::string& mount_name(const MountPoint& point) const {
    return pieces_[piece_of(point.along)].name;
  }
  /// Returns true if any mount uses `across`: a range of heights, or a ceiling.
  [[nodiscard]] bool is_wide() const { return wide_; }

  /// Evenly spread places, about `count` of them, at the lowest, middle and highest height where there is a
  /// choice.
  [[nodiscard]] MountLayout grid(std::size_t count) const;
  /// Regular layout: beacons evenly along the walls at half height (on ceilings in rows and columns).
  /// @param phase  from 0 to 1: position of the first one, as a fraction of the distance between two
  [[nodiscard]] MountLayout regular(std::size_t count, double phase) const;
  [[nodiscard]] MountLayout random(std::size_t count, Random& draws) const;

 private:
  /// A straight piece of a wall, a ceiling, or a pole.
  struct Piece {
    std::string name;
    SceneMount::Kind kind = SceneMount::Kind::kWall;
    std::vector<Eigen::Vector2d> points_m;  ///< wall: both ends; ceiling: its corners; pole: one
    Eigen::AlignedBox2d box;                ///< extent of a ceiling
    double low_m = 0.0, high_m = 0.0;
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();
    double length_m = 0.0;  ///< its share of `along`
  };
  [[nodiscard]] std::size_t piece_of(double along) const;
  void add(const SceneMount& mount);

  std::vector<Piece> pieces_;
  std::vector<double> ends_;  ///< end of each piece in `along`, rising to 1
  double length_m_ = 0.0, ceiling_m_ = 0.0;
  std::size_t pattern_ = kAllRound;
  bool wide_ = false;
};

}  // namespace octant::survey
