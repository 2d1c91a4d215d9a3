// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/adjust/leverage.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// What reliability needs of an observation's row: its residual in sigmas, its leverage (one less the
/// redundancy number), the largest shift of a beacon coordinate by it.
struct SweptRow {
  RowKind kind;
  std::size_t index;  ///< into the trajectory's list of that kind
  double residual, leverage, shift_m;
};
[[nodiscard]] SweptRow swept_row(const RowLeverage& row);

/// Whether a trajectory is one long chain, which is swept in stretches.
[[nodiscard]] bool has_long_chain(const Trajectory& trajectory);

/// Rows of every so many-th stop of a trajectory of stops, in their order. Stops hang together by the shared
/// parameters alone: stretches of them are swept side by side.
[[nodiscard]] std::vector<SweptRow> sweep_spread_stops(const LeverageSweep& sweep,
                                                       const Trajectory& trajectory, const SharedState& state,
                                                       std::size_t stride, int threads);

/// Rows of evenly spread stretches of a long drive, one part in `every` of it, in their order: each stretch
/// with margins that are swept but not returned, as beyond some hundred arrivals a state does not feel where
/// the chain was cut.
[[nodiscard]] std::vector<SweptRow> sweep_spread_stretches(const LeverageSweep& sweep,
                                                           const Trajectory& trajectory,
                                                           const SharedState& state, std::size_t stride,
                                                           int threads);

}  // namespace octant::calib
