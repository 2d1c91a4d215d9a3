// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/solution/solve_options.h"
#include "calib/statements/refit.h"

namespace octant::calib {

/// A beacon that hung elsewhere from some time on.
struct Move {
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double time_s = 0.0, sigmas = 0.0, cost = 0.0;
};

/// Times at which a beacon may have moved: where its arrivals begin or cease to be left out, and half way
/// through. None where it has few.
[[nodiscard]] std::vector<double> times_of_change(const Fit& fit, std::size_t beacon);

/// The fit in which a beacon's arrivals after some time are those of another one (the site's last), of which
/// nothing is known.
[[nodiscard]] Fit split_fit(const SolveOptions& options, const Fit& fit, std::size_t beacon, double time_s);

/// When such a fit's beacon changed its place, by where its arrivals fit: at the earlier place before, at the
/// later one after it, with the least sum of squares, each up to `limit` squared. None where too few are on
/// either side.
[[nodiscard]] std::optional<double> best_time_of_change(const Fit& split, std::size_t beacon, double limit);

/// By how much and how surely the two halves of such a fit differ.
[[nodiscard]] Move move_of(const SolveOptions& options, const Fit& split, std::size_t beacon, double time_s);

/// A motion of the vehicle during a stop.
struct StopMotion {
  double gain = 0.0;    ///< of a second pose: half the squares that it saves
  double by_m = 0.0;    ///< from the pose before to that after, in the plane
  double time_s = 0.0;  ///< between the two
};

/// The motion by which two poses, one before and one after some instant, explain a stop's arrivals better
/// than one, by half the squares, each up to `limit`. None where they do not by more than chance, where the
/// stop has too few arrivals to tell, or where a single beacon's do not fit: the echoes of one are no motion.
[[nodiscard]] std::optional<StopMotion> motion_during(const Trajectory& trajectory, const Segment& stop,
                                                      const SharedState& state, double limit);

}  // namespace octant::calib
