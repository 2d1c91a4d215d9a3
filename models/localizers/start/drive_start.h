// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/start/tracker_options.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// A stretch of a drive whose place is known.
struct DriveStart {
  bool found = false;
  std::size_t first_node = 0, last_node = 0;  ///< [first, last) of the stretch
};

/// Places a stretch if the arrivals settle it: the odometry is taken as a rigid piece, whose middle pose is
/// found as an epoch's is, with lever arms along the path; then its states are settled robustly. False:
/// nothing of it is clear.
[[nodiscard]] bool place_stretch(Trajectory& trajectory, const Segment& stretch, const EpochFixModel& model,
                                 const TrackerOptions& options);

/// Spans of the stretches that are tried.
struct StartWindows {
  double first_s = 0.0, longest_s = 0.0;
};

/// The first stretch at or after from_node that can be placed: from the first node at which anything is heard
/// windows grow up to the longest span, then from half a window on.
/// @param place  places a stretch, if it can be
[[nodiscard]] DriveStart first_placed(const Trajectory& trajectory, const Segment& segment,
                                      const StartWindows& windows, std::size_t from_node,
                                      const std::function<bool(const Segment&)>& place);

/// Searches the place of the first stretch at or after from_node that the arrivals settle: the odometry of a
/// window is taken as a rigid piece, whose middle pose is found as an epoch's is, with lever arms along the
/// path. The window grows until one pose is far better than any other, then its states are settled robustly.
/// Sets the nodes of the stretch, marks nothing.
[[nodiscard]] DriveStart find_start(Trajectory& trajectory, const Segment& segment,
                                    const EpochFixModel& model, const TrackerOptions& options,
                                    std::size_t from_node);

}  // namespace octant
