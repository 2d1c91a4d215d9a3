// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
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

}  // namespace octant::calib
