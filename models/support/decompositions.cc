// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/decompositions.h"

namespace octant {

template <class Matrix>
SymmetricEigen<Matrix>::SymmetricEigen(const Matrix& symmetric, int options)
    : Eigen::SelfAdjointEigenSolver<Matrix>(symmetric, options) {}

template class SymmetricEigen<Eigen::MatrixXd>;
template class SymmetricEigen<SmallSquare>;
template class SymmetricEigen<Eigen::Matrix2d>;
template class SymmetricEigen<Eigen::Matrix3d>;
template class SymmetricEigen<Eigen::Matrix4d>;

Eigen::MatrixXd symmetric_root(const Eigen::MatrixXd& A) {
  const SymmetricEigen<Eigen::MatrixXd> eigen(A);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& C) {
  if (C.rows() == 0) return {};
  // Scaled, because metres, seconds and metres per second occur together.
  const Eigen::VectorXd sigma = C.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const SymmetricEigen<Eigen::MatrixXd> eigen(inverse.asDiagonal() * C * inverse.asDiagonal());
  const auto kept = (eigen.eigenvalues().array() > 1e-12).count();  // ascending: the last ones
  return sigma.asDiagonal() * eigen.eigenvectors().rightCols(kept) *
         eigen.eigenvalues().tail(kept).cwiseSqrt().asDiagonal();
}

PivotedQr::PivotedQr(const Eigen::MatrixXd& matrix) : Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(matrix) {}

Eigen::MatrixXd PivotedQr::basis() const {
  return householderQ() * Eigen::MatrixXd::Identity(rows(), rank());
}

Eigen::MatrixXd PivotedQr::transposed_times(Eigen::MatrixXd B) const {
  B.applyOnTheLeft(householderQ().adjoint());
  return B;
}

DenseLdlt::DenseLdlt(const Eigen::MatrixXd& symmetric) : Eigen::LDLT<Eigen::MatrixXd>(symmetric) {}

}  // namespace octant
