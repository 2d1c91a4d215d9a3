// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/clocks/clock_log.h"

namespace octant::calib {

/// Approximate clocks of a run relative to a reference clock: offset [s] at the middle of the run and
/// relative rate. Distances are neglected, so the lines are good to the extent of the site.
struct ClockLines {
  double middle_s = 0.0;
  std::vector<Eigen::Vector2d> line;  ///< by number of the clock
  /// Time of each transmission on the reference clock, and the same relative to Transmission::time_s.
  std::vector<double> time_s, after_s;
  [[nodiscard]] double offset_s(int clock, double at_s) const {
    const Eigen::Vector2d& l = line[static_cast<std::size_t>(clock)];
    return l[0] + l[1] * (at_s - middle_s);
  }
};

/// Fits the lines by iteratively reweighted least squares (least sum of absolute residuals).
[[nodiscard]] ClockLines clock_lines(const std::vector<const Transmission*>& transmissions,
                                     const ClockModel& clocks, int reference_clock);

}  // namespace octant::calib
