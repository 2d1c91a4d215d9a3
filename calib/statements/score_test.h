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

/// Derivative of a whitened observation by the size of each common error. `by` is zero at input.
/// @return false if no error affects the row
using ErrorPatterns = std::function<bool(const Trajectory&, const ObservationRow&, Eigen::RowVectorXd& by)>;

/// Shared parameters as an adjustment left them.
struct AdjustedParameters {
  const ParameterLayout& layout;
  const Covariance& covariance;  ///< for the noise of the rows
  double share = 1.0;            ///< examined share of the observations that determined the parameters
};

/// Score test (Rao 1948; for errors of known pattern the w-test of Baarda 1968) of errors C = (c1, c2, ...)
/// that an adjustment with residuals r does not model. States and shared parameters follow the errors. With C
/// after elimination of the states, the rows J of the parameters and their covariance Q:
///   gradient C'r, its covariance C'C - (J'C)' Q (J'C), its derivative by the sizes C'C - (J'C)' Q (J'C) /
///   share
/// `share` is the examined share of the rows that determined Q and the parameters, which follow the errors of
/// all rows.
class ScoreTest {
 public:
  ScoreTest(Eigen::Index parameters, Eigen::Index errors);
  /// @param by  effect of the errors on a row after elimination of the states; whitened
  void add_row(double residual, const RowEntries& shared, const Eigen::RowVectorXd& by);
  /// Adds the sums of the same errors in other observations.
  void add(const ScoreTest& other);

  struct Finding {
    Eigen::VectorXd size;  ///< size that explains the residuals best
    /// Square root of the decrease of the sum of squares; for a single error with the sign of its size
    double sigmas = 0.0;
  };
  /// Tests several sums of the errors together. The result is zero if the parameters absorb all but a
  /// fiftieth of a sum, which could then have other causes.
  /// @param sums  one column of weights of the errors for each sum
  [[nodiscard]] Finding of(const Eigen::MatrixXd& sums, const AdjustedParameters& parameters) const;
  [[nodiscard]] Finding of_error(Eigen::Index error, const AdjustedParameters& parameters) const;

  /// Shift of the parameters due to an unmodelled error of size one: -Q J'c.
  [[nodiscard]] Eigen::VectorXd shift(Eigen::Index error, const Covariance& covariance) const;

  [[nodiscard]] const Eigen::VectorXd& gradient() const { return gradient_; }
  /// C'C - (J'C)' Q (J'C) / share for sums `a` (rows) and `b` (columns).
  [[nodiscard]] Eigen::MatrixXd information(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                            const Covariance& covariance, double share = 1.0) const;

 private:
  /// (J'C)' Q (J'C) for sums `a` (rows) and `b` (columns).
  [[nodiscard]] Eigen::MatrixXd taken_up(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                         const Covariance& covariance) const;

  Eigen::VectorXd gradient_;
  Eigen::MatrixXd squares_;                                                               ///< C'C
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_parameters_;  ///< J'C
};

/// Computes the score test in one pass over the states, without an adjustment.
/// @param trajectories  adjusted, or a part of those from which the parameters are
/// @param errors        number of errors: columns filled by `patterns`
[[nodiscard]] ScoreTest score_test(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                   const ParameterLayout& layout, Eigen::Index errors,
                                   const ErrorPatterns& patterns, int threads = 1);
/// Score test of one segment, such as a stop.
[[nodiscard]] ScoreTest score_test(const Trajectory& trajectory, const Segment& segment,
                                   const SharedState& state, const ParameterLayout& layout,
                                   Eigen::Index errors, const ErrorPatterns& patterns);

}  // namespace octant::calib
