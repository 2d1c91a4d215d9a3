// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/adjust/estimate.h"
#include "calib/problem/problem.h"

namespace octant::calib {

/// What the final rejection will leave of a solution: squares up to its limit, and the priors. Lower is a
/// larger consensus.
struct ConsensusCost {
  double arrivals = 0.0;
  double others = 0.0;  ///< bearings, measured poses, priors
  [[nodiscard]] double total() const { return arrivals + others; }
};
/// Early arrivals are so much rarer than late ones, as in the search of a fix (ln 20, consensus.cc): by this
/// many more half squares a consensus may be short of each that it leaves out.
inline constexpr double kEarlyIsRarer = 3.0;
/// What arrivals count for, trajectory by trajectory.
using ArrivalWeights = std::vector<std::vector<double>>;

/// @param weights  of the arrivals' squares; none: each counts in full
/// @param early_more  what an early arrival beyond the limit costs more than a late one
[[nodiscard]] ConsensusCost consensus_cost_of(const Problem& problem, const AdjustedLog& log,
                                              double rejection_sigmas, const ArrivalWeights& weights = {},
                                              double early_more = 0.0);

/// All arrivals of a pair at one place count as a few at most: a hundred echoes that one stand recorded are
/// no more than one.
[[nodiscard]] ArrivalWeights weights_by_place(const Problem& problem,
                                              const std::vector<Trajectory>& trajectories);

/// Which of two solutions the observations prefer.
enum class Preference { kFirst, kSecond, kNeither };

/// Compares a solution with its mirror image, both adjusted. Bearings, measured poses and priors decide
/// beyond four sigmas; ranges alone only where they differ by so much that errors common to a pair or to a
/// place are no excuse.
/// @param noise  of the arrivals over the stated one
[[nodiscard]] Preference prefer(const ConsensusCost& first, const ConsensusCost& second, double noise);

/// The same of two solutions, adjusted, with weights_by_place and the first one's noise.
[[nodiscard]] Preference prefer_by_all(const Problem& problem, const AdjustedLog& first,
                                       const AdjustedLog& second, double rejection_sigmas);
/// Half the squares by which the arrivals speak against the second of two solutions (negative: against the
/// first), worth as much as of white noise: residuals that keep together within a pair of beacon and
/// receiver, or at a place, along the difference of both solutions count for less, by the variance that they
/// give its sum (Liang and Zeger 1986).
[[nodiscard]] double arrivals_against(const Problem& problem, const AdjustedLog& first,
                                      const AdjustedLog& second, double rejection_sigmas);
/// Two places of a beacon of a planar site that differ in height.
[[nodiscard]] bool is_across_receivers(const Problem& problem, const Eigen::Vector3d& p_m,
                                       const Eigen::Vector3d& image_m);
/// Compares a beacon above the receivers with its image below them, or the reverse: receivers at slightly
/// different heights tell, where those are known.
[[nodiscard]] Preference prefer_height(const Problem& problem, const AdjustedLog& first,
                                       const AdjustedLog& second, double rejection_sigmas);

/// A beacon of a planar site as far below the receivers as it is above them, or the reverse: what arrivals do
/// not tell where all receivers are at one height. None where the prior of its height tells, or there is
/// none, or both are one place to the tolerance for beacons.
[[nodiscard]] std::optional<Eigen::Vector3d> image_across_receivers(const Problem& problem,
                                                                    const Estimate& estimate,
                                                                    std::size_t beacon);

/// Vehicles of a planar site stand on z = 0: a beacon below that is under the floor.
[[nodiscard]] inline bool is_under_floor(const Eigen::Vector3d& p_map_m) {
  constexpr double kMargin_m = 0.05;
  return p_map_m.z() < -kMargin_m;
}

/// Whether all known places of a planar site lie in one line (there are two at least), and nothing tells left
/// from right.
[[nodiscard]] bool is_known_in_line(const Problem& problem, const AdjustedLog& log);

/// Turns a planar site into its mirror image: beacons in the layout and states without a measured pose are
/// reflected in the line of all that is known, or in any line where that is less than two places. False (and
/// nothing is changed) where all beacons are fixed, where known places do not lie in line, where odometry or
/// receivers that are no line tell left from right, or in space.
/// @param off_line_m  how far known places may lie off the line beside what their sigmas allow
[[nodiscard]] bool reflect_site(const Problem& problem, AdjustedLog& log, double off_line_m = 0.0);

}  // namespace octant::calib
