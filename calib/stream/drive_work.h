// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/chain/chain_reduction.h"
#include "calib/stream/drive_index.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// A piece of a drive that a worker has at hand.
struct DriveWork {
  const DrivePiece* piece = nullptr;
  MeasurementLog log;
  std::vector<Trajectory> trajectory;  ///< one: of the piece, a single segment
  OpenChain system;
  [[nodiscard]] Trajectory& t() { return trajectory.front(); }
  [[nodiscard]] const Trajectory& t() const { return trajectory.front(); }
};

}  // namespace octant::calib
