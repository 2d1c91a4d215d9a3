// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/adjust/adjust.h"
#include "calib/problem/parameters.h"
#include "models/deployment.h"

namespace octant::calib {

/// Measured poses, and the odometry and bearings of the same states: squares, and share of the redundancy
/// with fixed shared parameters.
struct PoseSquares {
  double squares = 0.0, redundancy = 0.0;  ///< of the poses
  double other_squares = 0.0, other_redundancy = 0.0;
  void add(const PoseSquares& other) {
    squares += other.squares;
    redundancy += other.redundancy;
    other_squares += other.other_squares;
    other_redundancy += other.other_redundancy;
  }
};
/// Needs a pass over the states, so it is computed only where the noise is estimated.
[[nodiscard]] PoseSquares squares_of_poses(const Trajectory& trajectory, const SharedState& state);

/// Reference of a sum of squares: counts that can be added over the parts of a log.
struct ObservationCounts {
  std::size_t used = 0, rejected = 0;  ///< arrivals
  double observations = 0.0;           ///< used observations of all kinds
  std::size_t states = 0;              ///< observable unknowns of the vehicle's states
  double squares_s2 = 0.0;             ///< sum of squares of the residuals of used arrivals
  void add(const ObservationCounts& other);
};
/// @param residuals  if false, squares_s2 remains zero, which saves time
[[nodiscard]] ObservationCounts count_observations(const Trajectory& trajectory, const SharedState& state,
                                                   int threads = 1, bool residuals = true);

/// Statistics of trajectories that were counted.
[[nodiscard]] CalibrationStatistics statistics_of(const Problem& problem, const ParameterLayout& layout,
                                                  ObservationCounts counts, double cost);

/// Counts, redundancy, variance factor and its two-sided chi-square test, from solved trajectories.
/// @param cost  1/2 the weighted sum of squares of everything, priors included
[[nodiscard]] CalibrationStatistics statistics_of(const Problem& problem, const ParameterLayout& layout,
                                                  const std::vector<Trajectory>& trajectories,
                                                  const SharedState& state, double cost, int threads = 1);

/// Two-sided p value of a sum of squares against chi-square with the given degrees of freedom.
[[nodiscard]] double chi_square_p(double sum_of_squares, double degrees_of_freedom);

/// Result of an adjustment for NoiseSearch. A contradicted prior is not noise of the arrivals, so only
/// recordings count.
struct DataSquares {
  double cost = 0.0;  ///< half their sum, with the current noise
  double redundancy = 0.0;
  PoseSquares poses = {};  ///< their part of both
};

/// Factors on the noise.
struct NoiseFactors {
  double arrivals = 1.0;
  double poses = 1.0;  ///< measured poses
  [[nodiscard]] bool are_one() const { return arrivals == 1.0 && poses == 1.0; }
};

/// Estimates the noise of the arrivals: it is scaled until the squares agree with the redundancy, with one
/// adjustment for each step. If there are only arrivals, the variance factor is proportional to 1 / f^2 for a
/// noise factor f, and one step suffices. Odometry, whose noise is fixed, and measured poses keep a part that
/// does not depend on f: steps then follow a + b / f^2 through the last two adjustments.
///
/// Odometry and bearings beside measured poses do not count, because their noise is fixed.
///
/// Poses that are more accurate than expected would reduce the noise of the arrivals without bound. They get
/// their own variance component: each of the two is multiplied by the ratio of its squares to its redundancy
/// (Foerstner 1979), which keeps their ratio if the data do not distinguish them. Poses that appear less
/// accurate than expected are not scaled, because common errors of the receivers look the same.
class NoiseSearch {
 public:
  /// @return ones if squares and redundancy agree, or if the difference is irrelevant
  [[nodiscard]] NoiseFactors step(const DataSquares& data);

 private:
  [[nodiscard]] double step_of_arrivals(double data_cost, double redundancy);

  double factor_ = 1.0;                    ///< factor of all steps so far
  double before_ = 1.0;                    ///< factor_ before the last step
  std::optional<double> variance_before_;  ///< variance factor then
};

/// Adjusts, and scales the noise by the squares. Small deviations are ignored unless the chi-square test is
/// significant; each scaling is followed by another adjustment.
/// @param adjust  returns DataSquares, or the failure that ends the search
/// @param scale_noise  receives NoiseFactors
/// @return the last result of `adjust`
template <class Adjust, class ScaleNoise>
auto adjust_and_scale_noise(Adjust&& adjust, ScaleNoise&& scale_noise) {
  constexpr int kNoiseRounds = 3, kPoseRounds = 6;
  NoiseSearch noise;
  for (int round = 1;; ++round) {
    auto squares = adjust();
    if (!squares) return squares;
    const NoiseFactors factors = noise.step(*squares);
    const bool are_poses_scaled = factors.poses != 1.0;
    if (are_poses_scaled && round >= kPoseRounds) return squares;
    if (!factors.are_one()) scale_noise(factors);
    if (factors.are_one() || (!are_poses_scaled && round >= kNoiseRounds)) return squares;
  }
}

}  // namespace octant::calib
