// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/trajectory/trajectory.h"

namespace octant {

/// Steps that gain less than this share of the cost are rounding.
inline constexpr double kSettledToRounding = 1e-13;

struct SettleOptions {
  int max_iterations = 30;
  double tolerance = kSettledToRounding;  ///< a step that gains less than this share of the cost is the last
  int threads = 1;                        ///< on stretches of a long planar chain
  bool hold_first = false, hold_last = false;  ///< these states of the segment stay where they are
};

/// As `settle` of trajectory.h, which is this one with its defaults.
SettleResult settle(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                    const RobustLoss& loss, const SettleOptions& options);

}  // namespace octant
