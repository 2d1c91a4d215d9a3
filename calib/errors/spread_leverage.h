// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/adjust/leverage.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Data of an observation's row for the reliability: its residual in sigmas, its leverage (one minus the
/// redundancy number), the largest shift of a beacon coordinate by it.
struct SweptRow {
  RowKind kind;
  std::size_t index;  ///< into the trajectory's list of that kind
  double residual, leverage, shift_m;
};
[[nodiscard]] SweptRow swept_row(const RowLeverage& row);

/// Returns true if a trajectory is one long chain, which is processed in segments.
[[nodiscard]] bool has_long_chain(const Trajectory& trajectory);

/// Rows of evenly spaced stops of a trajectory of stops, in their order. Stops are connected by the shared
/// parameters only, so parts of them are processed in parallel.
[[nodiscard]] std::vector<SweptRow> sweep_spread_stops(const LeverageSweep& sweep,
                                                       const Trajectory& trajectory, const SharedState& state,
                                                       std::size_t stride, int threads);

/// Rows of evenly spaced segments of a long drive, one part in `every` of it, in their order. Each segment
/// has margins that are processed but not returned, because a state does not depend on the end of a segment
/// some hundred arrivals away.
[[nodiscard]] std::vector<SweptRow> sweep_spread_stretches(const LeverageSweep& sweep,
                                                           const Trajectory& trajectory,
                                                           const SharedState& state, std::size_t stride,
                                                           int threads);

}  // namespace octant::calib
