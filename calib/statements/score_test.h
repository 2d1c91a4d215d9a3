// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "calib/adjust/covariance.h"
#include "calib/problem/parameters.h"
#include "calib/problem/shared_entries.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {

/// By how much a row (its observation, whitened) grows with the size of each of some errors that the
/// observations may have in common, which come as zeros; false: with none of them.
using ErrorPatterns = std::function<bool(const Trajectory&, const ObservationRow&, Eigen::RowVectorXd& by)>;

/// Shared parameters as an adjustment left them.
struct AdjustedParameters {
  const ParameterLayout& layout;
  const Covariance& covariance;  ///< by the noise that the rows have
  double share = 1.0;            ///< of the observations that they are from, that is looked at
};

/// What the residuals r of an adjustment say of errors C = (c1, c2, ...) that were not in it: score test (Rao
/// 1948; for errors of known pattern the w-test of Baarda 1968), states and shared parameters adjusted along.
/// With what the states leave of the errors, the parameters' rows J and their covariance Q,
///   gradient = C'r, with the covariance C'C - (J'C)' Q (J'C), and by the errors' sizes
///   C'C - (J'C)' Q (J'C) / share
/// where the rows are only a share of those that Q and the parameters are from: these have followed the
/// errors in all.
class ScoreTest {
 public:
  ScoreTest(Eigen::Index parameters, Eigen::Index errors);
  /// @param by  the errors in a row, less what the states take up of them; whitened
  void add_row(double residual, const RowEntries& shared, const Eigen::RowVectorXd& by);
  /// Of those errors that are the same in other observations.
  void add(const ScoreTest& other);

  struct Finding {
    Eigen::VectorXd size;  ///< that explains the residuals best
    double sigmas = 0.0;  ///< root of what that takes off the sum of their squares; with the sign of one size
  };
  /// Of errors that are sums of these, together. None where the parameters take up all but a fiftieth of
  /// one: what bends them may be no error at all.
  /// @param sums  a column each, of weights of the errors
  [[nodiscard]] Finding of(const Eigen::MatrixXd& sums, const AdjustedParameters& parameters) const;
  [[nodiscard]] Finding of_error(Eigen::Index error, const AdjustedParameters& parameters) const;

  /// By how much the parameters follow an error of size one that the adjustment does not know of: -Q J'c.
  [[nodiscard]] Eigen::VectorXd shift(Eigen::Index error, const Covariance& covariance) const;

  [[nodiscard]] const Eigen::VectorXd& gradient() const { return gradient_; }
  /// C'C - (J'C)' Q (J'C) / share, of sums `a` (rows) with sums `b` (columns).
  [[nodiscard]] Eigen::MatrixXd information(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                            const Covariance& covariance, double share = 1.0) const;

 private:
  /// (J'C)' Q (J'C), of sums `a` with sums `b`.
  [[nodiscard]] Eigen::MatrixXd taken_up(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                         const Covariance& covariance) const;

  Eigen::VectorXd gradient_;
  Eigen::MatrixXd squares_;                                                               ///< C'C
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_parameters_;  ///< J'C
};

/// Takes one sweep over the states and adjusts nothing.
/// @param trajectories  adjusted, or a part of those from which the parameters are
/// @param errors        how many; columns of what `patterns` fills
[[nodiscard]] ScoreTest score_test(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                   const ParameterLayout& layout, Eigen::Index errors,
                                   const ErrorPatterns& patterns, int threads = 1);
/// The same of one segment: of a stop.
[[nodiscard]] ScoreTest score_test(const Trajectory& trajectory, const Segment& segment,
                                   const SharedState& state, const ParameterLayout& layout,
                                   Eigen::Index errors, const ErrorPatterns& patterns);

}  // namespace octant::calib
