// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace octant {

/// A symmetric matrix A = S R S with R of unit diagonal (Jacobi scaling): of a covariance, standard
/// deviations and correlations. Metres, seconds and radians stand beside each other in A and are comparable
/// in R, so that eigenvalues and pivots of R are judged and inverted.
template <class Matrix>
struct UnitDiagonal {
  using Vector =
      Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1, Eigen::ColMajor, Matrix::MaxRowsAtCompileTime, 1>;

  Vector scale, inverse_scale;  ///< diagonals of S and its inverse
  Matrix scaled;                ///< R

  /// @param least  the diagonal of A counts as no less than this: rounding may leave zero of it, or less
  explicit UnitDiagonal(const Matrix& A, double least = 1e-300)
      : scale(A.diagonal().cwiseMax(least).cwiseSqrt()),
        inverse_scale(scale.cwiseInverse()),
        scaled(inverse_scale.asDiagonal() * A * inverse_scale.asDiagonal()) {}

  /// The inverse of A from the eigenvectors of R and the inverses of its eigenvalues, of which any may be set
  /// to zero (pseudo-inverse).
  [[nodiscard]] Matrix inverse(const Matrix& eigenvectors, const Vector& inverse_values) const {
    return inverse_scale.asDiagonal() * eigenvectors * inverse_values.asDiagonal() *
           eigenvectors.transpose() * inverse_scale.asDiagonal();
  }
};

}  // namespace octant
