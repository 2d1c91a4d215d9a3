// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/adjust/adjust.h"
#include "calib/problem/parameters.h"
#include "models/deployment.h"

namespace octant::calib {

/// Measured poses and their share of the redundancy, with fixed shared parameters.
struct PoseSquares {
  double squares = 0.0, redundancy = 0.0;
  void add(const PoseSquares& other) {
    squares += other.squares;
    redundancy += other.redundancy;
  }
};
/// Costs a sweep over the states: where the noise is looked for, and nowhere else.
[[nodiscard]] PoseSquares squares_of_poses(const Trajectory& trajectory, const SharedState& state);

/// Reference of a sum of squares: counts that can be added over the parts of a log.
struct ObservationCounts {
  std::size_t used = 0, rejected = 0;  ///< arrivals
  double observations = 0.0;           ///< used observations of all kinds
  std::size_t states = 0;              ///< unknowns of the vehicle's states, as far as anything observes them
  double squares_s2 = 0.0;             ///< sum of squares of the residuals of used arrivals
  void add(const ObservationCounts& other);
};
/// @param residuals  false: squares_s2 stays zero, which saves the time
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
  double cost = 0.0;  ///< half their sum, with the noise as it is now
  double redundancy = 0.0;
  PoseSquares poses = {};  ///< the part of both that they have
};

/// By what noise is multiplied.
struct NoiseFactors {
  double arrivals = 1.0;
  double poses = 1.0;  ///< measured ones
  [[nodiscard]] bool are_one() const { return arrivals == 1.0 && poses == 1.0; }
};

/// The noise of the arrivals by the squares: it is multiplied until these agree with their redundancy, an
/// adjustment for each step. Where arrivals are all that is observed, the variance factor falls as 1 / f^2
/// with the noise, and one step does. Odometry, whose noise stays as stated, and measured poses keep a part
/// of it whatever f is: steps then follow a + b / f^2 through the last two adjustments.
///
/// Poses that were measured better than stated would drag the noise of the arrivals towards nothing, which
/// then explains all. They get a component of variance of their own: each of the two is multiplied by its
/// squares over its redundancy (Foerstner 1979), which keeps their ratio where the data cannot tell them
/// apart. Poses that seem worse than stated are left: what receivers have in common looks the same.
class NoiseSearch {
 public:
  /// @return ones where squares and redundancy agree, or where that is of no consequence
  [[nodiscard]] NoiseFactors step(const DataSquares& data);

 private:
  [[nodiscard]] double step_of_arrivals(double data_cost, double redundancy);

  double factor_ = 1.0;                    ///< factor of all steps so far
  double before_ = 1.0;                    ///< factor_ a step ago
  std::optional<double> variance_before_;  ///< variance factor then
};

/// Adjusts with the noise as the squares show it: small departures wait for the chi-square test of an
/// adjustment, and each one that it finds is followed by another adjustment.
/// @param adjust  gives DataSquares, or the failure that ends the search
/// @param scale_noise  takes NoiseFactors
/// @return what `adjust` gave last
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
