// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/decompositions.h"

namespace octant {

template <class Matrix>
SymmetricEigen<Matrix>::SymmetricEigen(const Matrix& symmetric, int options)
    : Eigen::SelfAdjointEigenSolver<Matrix>(symmetric, options) {}

template class SymmetricEigen<Eigen::MatrixXd>;
template class SymmetricEigen<NodeBlock>;
template class SymmetricEigen<Eigen::Matrix2d>;
template class SymmetricEigen<Eigen::Matrix3d>;
template class SymmetricEigen<Eigen::Matrix4d>;

Eigen::MatrixXd symmetric_root(const Eigen::MatrixXd& A) {
  const SymmetricEigen<Eigen::MatrixXd> eigen(A);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
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
