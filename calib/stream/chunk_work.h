// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "calib/adjust/tile.h"
#include "calib/problem/thin.h"
#include "calib/stream/log_index.h"
#include "models/fix.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Where a planar state is, between readings: x, y, heading; NaN: no place.
using KeptState = std::array<double, 3>;
[[nodiscard]] inline bool has_place(const KeptState& state) { return !std::isnan(state[2]); }
[[nodiscard]] inline Pose pose_of(const KeptState& state) {
  return Pose::planar(state[0], state[1], state[2]);
}
[[nodiscard]] inline KeptState kept_state(const Node& node) {
  return {node.T_map_vehicle.translation_m.x(), node.T_map_vehicle.translation_m.y(),
          node.placed ? node.T_map_vehicle.heading_rad() : NAN};
}
inline void put_state(const KeptState& state, Node& node) {
  node.placed = has_place(state);
  if (node.placed) node.T_map_vehicle = pose_of(state);
}

/// Makes a worker's log one of another run. The room of its arrivals stays.
inline void begin_run(const MeasurementLog& run, MeasurementLog& log) {
  std::vector<Arrival> room = std::move(log.arrivals);
  log = without_lists(run);
  log.arrivals = std::move(room);
}

[[nodiscard]] inline Error changed_while_read(const MeasurementLog& log) {
  return {.file = log.path + "/tof.csv",
          .found = "the file has changed while it was read",
          .expected = "the same rows each time, as a log of this size is read several times",
          .advice = "calibrate with a copy, or when the recording is over"};
}

/// A chunk of a log that a worker has at hand.
struct ChunkWork {
  const LogChunk* chunk = nullptr;
  MeasurementLog log;
  std::vector<Trajectory> trajectories;
  ReducedSystem system;
};

/// What remains of a chunk between the readings, trajectory by trajectory.
struct ChunkStops {
  std::vector<KeptState> pose;
  std::vector<float> start_heading_rad;
  std::vector<Rejection> marks;  ///< of the arrivals
};

}  // namespace octant::calib
