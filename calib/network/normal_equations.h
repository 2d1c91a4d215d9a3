// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "calib/adjust/sparse_factor.h"

namespace octant::calib {

/// Sparse normal equations of a network, and their inverse under inner constraints.
///
/// The null vectors M of the normal matrix are the motions that no observation detects. As many unknowns
/// (pins) receive a unit of weight, which makes the matrix regular, and S = I - M (C^T M)^-1 C^T transforms
/// solution and inverse to the datum, where C has the rows of M at the datum coordinates (Baarda's
/// S-transformation).
class NormalEquations {
 public:
  /// @param jacobian  whitened
  /// @param points  columns of the coordinates of each point; -1 where there is none
  /// @param datum  columns of the datum coordinates
  NormalEquations(const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian,
                  const std::vector<std::array<int, 3>>& points, const std::vector<int>& datum);

  /// Unknowns that neither observations nor datum determine; then there is no solution.
  [[nodiscard]] const std::vector<int>& undetermined() const { return undetermined_; }
  [[nodiscard]] int defect() const { return static_cast<int>(motions_.cols()); }
  /// Minimum over the datum coordinates of |offset + solution|.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right_side, const Eigen::VectorXd& offset) const;
  /// Cofactors of a list of unknowns of one point, one observation or one covariance matrix of observations.
  [[nodiscard]] Eigen::MatrixXd cofactors(const std::vector<int>& unknowns) const;
  /// Quadratic form of the inverse with a vector of observable quantities: independent of the datum.
  [[nodiscard]] double variance(const Eigen::SparseVector<double>& row) const;
  /// All cofactors, as a dense matrix.
  [[nodiscard]] Eigen::MatrixXd all_cofactors() const;

 private:
  [[nodiscard]] Eigen::MatrixXd solve_pinned(const Eigen::MatrixXd& right_side) const;
  [[nodiscard]] double pinned_cofactor(Eigen::Index i, Eigen::Index j) const;
  void add_datum(const std::vector<int>& datum);

  Eigen::VectorXd scale_;  ///< one over the root of the diagonal
  Eigen::MatrixXd motions_, constraints_, to_datum_;
  Eigen::MatrixXd pinned_constraints_;  ///< pinned inverse times constraints times (M^T C)^-1
  Eigen::MatrixXd constraint_cofactors_;
  std::unique_ptr<SparseFactor> factor_;  ///< of the scaled and pinned matrix
  std::vector<int> undetermined_;
};

}  // namespace octant::calib
