// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/start/tracker_options.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// A part of a drive whose pose is known.
struct DriveStart {
  bool found = false;
  std::size_t first_node = 0, last_node = 0;  ///< nodes [first, last)
};

/// Finds the pose of a part of a drive, if the arrivals determine it. Its odometry is treated as a rigid
/// piece with lever arms along the path, and the pose of its middle node is searched like that of an epoch.
/// Its states are then solved robustly. Returns false if no pose is clearly the best.
[[nodiscard]] bool place_stretch(Trajectory& trajectory, const Segment& stretch, const EpochFixModel& model,
                                 const TrackerOptions& options);

/// Durations of the parts that are tried.
struct StartWindows {
  double first_s = 0.0, longest_s = 0.0;
};

/// Finds the first part at or after from_node whose pose can be found. Windows begin at the first node with
/// an arrival and grow up to the longest duration; then the next window begins half a window later.
/// @param place  finds the pose of a part and returns true if it succeeds
[[nodiscard]] DriveStart first_placed(const Trajectory& trajectory, const Segment& segment,
                                      const StartWindows& windows, std::size_t from_node,
                                      const std::function<bool(const Segment&)>& place);

/// Finds the pose of the first part at or after from_node that the arrivals determine (place_stretch). The
/// window grows until one pose is far better than any other. Sets the nodes of the part, but marks no
/// arrivals.
[[nodiscard]] DriveStart find_start(Trajectory& trajectory, const Segment& segment,
                                    const EpochFixModel& model, const TrackerOptions& options,
                                    std::size_t from_node);

}  // namespace octant
