// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/trajectory/trajectory.h"

namespace octant {

/// Steps that gain less than this share of the cost are rounding.
inline constexpr double kSettledToRounding = 1e-13;

[[nodiscard]] inline bool is_plain(const RobustLoss& loss) {
  return loss.late_scale <= 0.0 && loss.early_scale <= 0.0;
}

struct SettleOptions {
  int max_iterations = 30;
  double tolerance = kSettledToRounding;  ///< a step that gains less than this share of the cost is the last
  /// With plain squares so is one whose length foretells that the next would gain less than this share.
  double left_behind = 0.0;
  int threads = 1;                             ///< on stretches of a long chain
  bool hold_first = false, hold_last = false;  ///< these states of the segment stay where they are
};

/// As `settle` of trajectory.h, which is this one with its defaults.
SettleResult settle(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                    const RobustLoss& loss, const SettleOptions& options);

}  // namespace octant
