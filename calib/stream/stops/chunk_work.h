// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/adjust/tile.h"
#include "calib/stream/kept_states.h"
#include "calib/stream/stops/log_index.h"
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
  std::vector<KeptStates> states;
  std::vector<float> start_heading_rad;
  std::vector<Rejection> marks;  ///< of the arrivals, then of the bearings
};

}  // namespace octant::calib
