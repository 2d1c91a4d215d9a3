// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "models/physics/pose.h"

namespace octant::calib {

/// A way in which poses are written in a left-handed frame: some axis of the map, and with it the sense of
/// turning, is the other way round.
struct Reflection {
  const char* words;
  std::function<Pose(const Pose&)> read;  ///< the pose in the right-handed frame
};
/// Those that other programs write: y or x the other way round, x and y exchanged (north, east, down),
/// headings clockwise.
[[nodiscard]] const std::vector<Reflection>& reflections();

/// Turn about the vertical and shift that take points of one frame to those of another, by least squares
/// (Umeyama 1991, in the plane and without a scale); nothing of points that do not tell a turn.
[[nodiscard]] std::optional<Pose> frame_between(const std::vector<Eigen::Vector3d>& from,
                                                const std::vector<Eigen::Vector3d>& to);

}  // namespace octant::calib
