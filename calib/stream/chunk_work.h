// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "calib/adjust/tile.h"
#include "calib/stream/log_index.h"
#include "models/fix.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// A chunk of a log that a worker has at hand.
struct ChunkWork {
  const LogChunk* chunk = nullptr;
  MeasurementLog log;
  std::vector<Trajectory> trajectories;
  ReducedSystem system;
};

/// What remains of a chunk between the readings, trajectory by trajectory.
struct ChunkStops {
  std::vector<std::array<double, 3>> pose;  ///< x, y, heading; NaN: no place
  std::vector<float> start_heading_rad;
  std::vector<Rejection> marks;  ///< of the arrivals
};

}  // namespace octant::calib
