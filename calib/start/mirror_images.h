// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/adjust/estimate.h"
#include "calib/problem/problem.h"

namespace octant::calib {

/// Cost of a solution after the final rejection: squares up to its limit, and the priors. Lower is a larger
/// consensus.
struct ConsensusCost {
  double arrivals = 0.0;
  double others = 0.0;  ///< bearings, measured poses, priors
  [[nodiscard]] double total() const { return arrivals + others; }
};
/// Additional cost of a rejected early arrival, in half squares. Early arrivals are rarer than late ones (ln
/// 20 in the search of a fix, consensus.cc).
inline constexpr double kEarlyIsRarer = 3.0;
/// Weights of arrivals, trajectory by trajectory.
using ArrivalWeights = std::vector<std::vector<double>>;

/// @param weights     of the arrivals' squares; empty: full weight
/// @param early_more  additional cost of an early arrival beyond the limit
[[nodiscard]] ConsensusCost consensus_cost_of(const Problem& problem, const AdjustedLog& log,
                                              double rejection_sigmas, const ArrivalWeights& weights = {},
                                              double early_more = 0.0);

/// Weights with which all arrivals of a pair at one place count as a few at most, because a hundred echoes at
/// one stop are a single event.
[[nodiscard]] ArrivalWeights weights_by_place(const Problem& problem,
                                              const std::vector<Trajectory>& trajectories);

/// Solution, out of two, that the observations prefer.
enum class Preference { kFirst, kSecond, kNeither };

/// Compares a solution with its mirror image, both adjusted. Bearings, measured poses and priors decide
/// beyond four sigmas. Ranges alone decide only if the difference exceeds errors common to a pair or a place.
/// @param noise  ratio of the noise of the arrivals to that of the site file
[[nodiscard]] Preference prefer(const ConsensusCost& first, const ConsensusCost& second, double noise);

/// Compares two adjusted solutions, with weights_by_place and the noise of the first one.
[[nodiscard]] Preference prefer_by_all(const Problem& problem, const AdjustedLog& first,
                                       const AdjustedLog& second, double rejection_sigmas);
/// Half squares by which the arrivals contradict the second of two solutions (negative: the first), in units
/// of white noise. Residuals that are correlated within a beacon-receiver pair, or at a place, along the
/// difference of both solutions have less weight, by the variance of its sum (Liang and Zeger 1986).
[[nodiscard]] double arrivals_against(const Problem& problem, const AdjustedLog& first,
                                      const AdjustedLog& second, double rejection_sigmas);
/// Returns true for two positions of a beacon of a planar site that differ in height.
[[nodiscard]] bool is_across_receivers(const Problem& problem, const Eigen::Vector3d& p_m,
                                       const Eigen::Vector3d& image_m);
/// Compares a beacon above the receivers with its image below them, or the reverse: receivers at slightly
/// different, known heights distinguish them.
[[nodiscard]] Preference prefer_height(const Problem& problem, const AdjustedLog& first,
                                       const AdjustedLog& second, double rejection_sigmas);

/// Image of a beacon of a planar site in the plane of the receivers, which arrivals do not exclude if all
/// receivers have one height. No value if the prior of its height excludes it, if there is no such prior, or
/// if both are one position within the tolerance.
[[nodiscard]] std::optional<Eigen::Vector3d> image_across_receivers(const Problem& problem,
                                                                    const Estimate& estimate,
                                                                    std::size_t beacon);

/// Vehicles of a planar site are at z = 0: a beacon below that is under the floor.
[[nodiscard]] inline bool is_under_floor(const Eigen::Vector3d& p_map_m) {
  constexpr double kMargin_m = 0.05;
  return p_map_m.z() < -kMargin_m;
}

/// Returns true if all known positions of a planar site are in one line (at least two), and no observation
/// distinguishes left from right.
[[nodiscard]] bool is_known_in_line(const Problem& problem, const AdjustedLog& log);

/// Reflects a planar site: beacons in the layout and states without a measured pose are reflected in the line
/// of all known positions, or in any line if there are fewer than two. Returns false, without a change, if
/// all beacons are fixed, if known positions are not collinear, if odometry or receivers that are not
/// collinear distinguish left from right, or in space.
/// @param off_line_m  permitted distance of known positions from the line, in addition to their sigmas
[[nodiscard]] bool reflect_site(const Problem& problem, AdjustedLog& log, double off_line_m = 0.0);

/// Moves all beacons to their images in the plane of a nearly flat path. One image alone contradicts the
/// others through the delay and the speed that they share. Returns false, without a change, if fewer than two
/// have an image.
/// @param sigma_m  stated noise of a range
[[nodiscard]] bool reflect_beacons(const Problem& problem, AdjustedLog& log, double sigma_m);

}  // namespace octant::calib
