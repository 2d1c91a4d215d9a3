// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/trajectory/trajectory.h"

namespace octant {

/// Steps that gain less than this share of the cost are rounding.
inline constexpr double kConvergedToRounding = 1e-13;

[[nodiscard]] inline bool is_plain(const RobustLoss& loss) {
  return loss.late_scale <= 0.0 && loss.early_scale <= 0.0;
}

struct StateSolveOptions {
  int max_iterations = 30;
  double tolerance =
      kConvergedToRounding;  ///< a step that gains less than this share of the cost is the last
  /// With plain squares so is one whose length predicts that the next would gain less than this share.
  double left_behind = 0.0;
  int threads = 1;                             ///< on stretches of a long chain
  bool hold_first = false, hold_last = false;  ///< these states of the segment stay where they are
};

/// As `solve_states` of trajectory.h, which is this one with its defaults.
StateSolveResult solve_states(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                              const RobustLoss& loss, const StateSolveOptions& options);

}  // namespace octant
