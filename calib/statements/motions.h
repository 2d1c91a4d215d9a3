// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/solution/solve_options.h"
#include "calib/statements/refit.h"

namespace octant::calib {

/// A change of a beacon's position at some time.
struct Move {
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double time_s = 0.0, sigmas = 0.0, cost = 0.0;
};

/// Change of a beacon's position within the limits of rejection.
struct PositionChange {
  double time_s = 0.0;
  double gain = 0.0;  ///< squares of the residuals that two positions save, by the first step to each
};
/// Most likely such change of a beacon; its gain is 0 if there are few arrivals.
[[nodiscard]] PositionChange likeliest_change(const Fit& fit, std::size_t beacon);

/// Times at which a beacon may have moved: where its arrivals begin or cease to be rejected, and its median
/// time. Empty if it has few arrivals.
[[nodiscard]] std::vector<double> times_of_change(const Fit& fit, std::size_t beacon);

/// Fit in which the arrivals of a beacon after some time belong to another beacon (the last of the site) at
/// an unknown position.
[[nodiscard]] Fit split_fit(const SolveOptions& options, const Fit& fit, std::size_t beacon, double time_s);

/// Most likely time of the move, given the two positions of such a fit: the smallest sum of squares, each
/// limited to `limit` squared, with arrivals before it at the earlier position and arrivals after it at the
/// later one. No value if there are too few arrivals on either side.
[[nodiscard]] std::optional<double> best_time_of_change(const Fit& split, std::size_t beacon, double limit);

/// Size and significance of the difference between the two positions of such a fit.
[[nodiscard]] Move move_of(const SolveOptions& options, const Fit& split, std::size_t beacon, double time_s);

/// A motion of the vehicle during a stop.
struct StopMotion {
  double gain = 0.0;    ///< half squares that a second pose saves
  double by_m = 0.0;    ///< distance between the two poses, in the plane
  double time_s = 0.0;  ///< time between the two poses
};

/// Finds a motion during a stop: two poses, before and after some time, explain its arrivals significantly
/// better than one, by half the squares, each limited to `limit` squared. No value if they do not, if the
/// stop has too few arrivals, or if only one beacon deviates, because its echoes are no motion.
[[nodiscard]] std::optional<StopMotion> motion_during(const Trajectory& trajectory, const Segment& stop,
                                                      const SharedState& state, double limit);

}  // namespace octant::calib
