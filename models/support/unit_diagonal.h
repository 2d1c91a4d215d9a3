// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace octant {

/// Decomposes a symmetric matrix as A = S R S with R of unit diagonal (Jacobi scaling). For a covariance, S
/// has the standard deviations and R the correlations. Elements of A with different units (metres, seconds,
/// radians) become comparable in R, so eigenvalues and pivots are judged there, and R is the matrix that is
/// inverted.
template <class Matrix>
struct UnitDiagonal {
  using Vector =
      Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1, Eigen::ColMajor, Matrix::MaxRowsAtCompileTime, 1>;

  Vector scale, inverse_scale;  ///< diagonals of S and its inverse
  Matrix scaled;                ///< R

  /// @param least  lower bound on the diagonal of A, which rounding may make zero or negative
  explicit UnitDiagonal(const Matrix& A, double least = 1e-300)
      : scale(A.diagonal().cwiseMax(least).cwiseSqrt()),
        inverse_scale(scale.cwiseInverse()),
        scaled(inverse_scale.asDiagonal() * A * inverse_scale.asDiagonal()) {}

  /// Inverse of A from the eigenvectors of R and the inverses of its eigenvalues. Set an inverse to zero for
  /// the pseudo-inverse.
  [[nodiscard]] Matrix inverse(const Matrix& eigenvectors, const Vector& inverse_values) const {
    return inverse_scale.asDiagonal() * eigenvectors * inverse_values.asDiagonal() *
           eigenvectors.transpose() * inverse_scale.asDiagonal();
  }
};

}  // namespace octant
