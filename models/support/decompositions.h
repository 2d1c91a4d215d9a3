// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace octant {

/// Wrappers of Eigen's decompositions that are compiled once, in decompositions.cc. Every other source file
/// that instantiated one would spend seconds on its templates. Results are read through Eigen's own
/// interface.

/// Square matrix of at most seven rows that needs no allocation: a block of the largest state.
using SmallSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 7, 7>;

/// @tparam Matrix  MatrixXd, SmallSquare, or fixed up to 4 x 4
template <class Matrix>
class SymmetricEigen : public Eigen::SelfAdjointEigenSolver<Matrix> {
 public:
  explicit SymmetricEigen(const Matrix& symmetric, int options = Eigen::ComputeEigenvectors);
};

extern template class SymmetricEigen<Eigen::MatrixXd>;
extern template class SymmetricEigen<SmallSquare>;
extern template class SymmetricEigen<Eigen::Matrix2d>;
extern template class SymmetricEigen<Eigen::Matrix3d>;
extern template class SymmetricEigen<Eigen::Matrix4d>;

/// Symmetric R with R R = A for a symmetric matrix A, negative eigenvalues set to zero. R depends
/// continuously on A.
[[nodiscard]] Eigen::MatrixXd symmetric_root(const Eigen::MatrixXd& A);

/// R with C = R R' for a covariance that may have lost rank by rounding; columns that contribute nothing are
/// omitted.
[[nodiscard]] Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& C);

class PivotedQr : public Eigen::ColPivHouseholderQR<Eigen::MatrixXd> {
 public:
  explicit PivotedQr(const Eigen::MatrixXd& matrix);
  /// Orthonormal basis of the column space; the number of columns is the rank.
  [[nodiscard]] Eigen::MatrixXd basis() const;
  /// Returns Q' B.
  [[nodiscard]] Eigen::MatrixXd transposed_times(Eigen::MatrixXd B) const;
};

class DenseLdlt : public Eigen::LDLT<Eigen::MatrixXd> {
 public:
  explicit DenseLdlt(const Eigen::MatrixXd& symmetric);
};

}  // namespace octant
