// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/trajectory/trajectory.h"

namespace octant {

/// Relative decrease of the cost below which a step is rounding error.
inline constexpr double kConvergedToRounding = 1e-13;

[[nodiscard]] inline bool is_plain(const RobustLoss& loss) {
  return loss.late_scale <= 0.0 && loss.early_scale <= 0.0;
}

struct StateSolveOptions {
  int max_iterations = 30;
  double tolerance = kConvergedToRounding;  ///< relative decrease of the cost that ends the iteration
  /// Without robust loss, the iteration also ends when the next step is predicted to gain less than this
  /// share.
  double left_behind = 0.0;
  int threads = 1;                             ///< threads that work on parts of a long chain
  bool hold_first = false, hold_last = false;  ///< keep the first or last state of the segment fixed
};

/// Solves for the states with options; `solve_states` of trajectory.h calls it with the defaults.
StateSolveResult solve_states(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                              const RobustLoss& loss, const StateSolveOptions& options);

}  // namespace octant
