// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace octant::calib {

/// Joint covariance of the shared parameters in internal units: the inverse of their information.
/// Undetermined directions have a huge but finite variance; those of a free datum have zero variance (inner
/// constraints: F'x = 0).
///
/// With some hundred parameters it is a matrix. With thousands it is the sparse Cholesky factor of the
/// information (CHOLMOD) and the part of the inverse in the factor's pattern, by Takahashi's recursion
/// (Takahashi, Fagan and Chen 1973; Erisman and Tinney 1975), supernode by supernode. It contains all pairs
/// of parameters that an observation connects; any other pair needs a solve. A free datum is then fixed by
/// pins, and results are transformed (Baarda's S-transformation, C = (I - F F') C_pinned (I - F F')).
class Covariance {
 public:
  Covariance();
  explicit Covariance(Eigen::MatrixXd matrix);
  /// @param information  symmetric, both triangles stored
  /// @param datum        orthonormal columns; empty if the datum is fixed
  Covariance(const Eigen::MatrixXd& information, const Eigen::MatrixXd& datum);
  Covariance(const Eigen::SparseMatrix<double>& information, const Eigen::MatrixXd& datum);

  [[nodiscard]] Eigen::Index size() const;
  /// The whole matrix; null where it is not formed.
  [[nodiscard]] const Eigen::MatrixXd* matrix() const;
  [[nodiscard]] bool all_finite() const;

  [[nodiscard]] double operator()(Eigen::Index i, Eigen::Index j) const;
  /// @param columns  -1: a fixed parameter, without variance
  [[nodiscard]] Eigen::MatrixXd block(std::span<const int> columns) const;
  [[nodiscard]] Eigen::VectorXd times(const Eigen::VectorXd& v) const;
  /// Whole columns, size() x their number.
  [[nodiscard]] Eigen::MatrixXd columns(const std::vector<int>& columns) const;

  struct Direction {
    double variance = 0.0;
    Eigen::VectorXd v;  ///< unit length
  };
  /// Eigenvectors of W C W with the largest variances, largest first, at most the given number and only with
  /// variances of `least` or more. For sparse covariances by Lanczos's method with full orthogonalisation
  /// (Golub and Van Loan, section 10.1).
  [[nodiscard]] std::vector<Direction> largest(const Eigen::VectorXd& weights, std::size_t most,
                                               double least) const;

 private:
  class Sparse;
  Eigen::MatrixXd matrix_;
  std::shared_ptr<const Sparse> sparse_;
};

}  // namespace octant::calib
