// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/normal_equations.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace octant::calib {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// Eigenvalues of the normal matrix with unit diagonal below this count as zero: sums of some thousand
/// products have rounding errors of 1e-13, and a determined network of ordinary shape stays above 1e-9.
constexpr double kZeroEigenvalue = 1e-11;
/// Shift that makes a singular matrix of unit diagonal positive definite despite rounding errors.
constexpr double kShift = 10.0 * kZeroEigenvalue;
/// Steps of subspace iteration; each one reduces a part with an eigenvalue above 1e-9 at least tenfold.
constexpr int kMostSteps = 30;
/// Motions of a rigid body in space, and its scale: the ordinary datum defect is at most this.
constexpr Eigen::Index kRigidMotions = 7;
/// Relative size from which a motion is no rounding error.
constexpr double kMoves = 1e-6;

Sparse identity(Eigen::Index n) {
  Sparse matrix(n, n);
  matrix.setIdentity();
  return matrix;
}

/// Orthonormal basis of a deterministic block that is not orthogonal to any particular vector.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& block) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(block).householderQ() *
         Eigen::MatrixXd::Identity(block.rows(), block.cols());
}

/// Null vectors of a positive semidefinite matrix with unit diagonal, by subspace iteration with the inverse
/// of the slightly shifted matrix.
Eigen::MatrixXd null_space(const Sparse& matrix) {
  const Eigen::Index n = matrix.rows();
  const auto factor = SparseFactor::of(matrix + kShift * identity(n));
  if (factor == nullptr) return {};
  for (Eigen::Index size = std::min(n, kRigidMotions + 1);; size = std::min(n, 2 * size)) {
    Eigen::MatrixXd block(n, size);
    for (Eigen::Index c = 0; c < size; ++c)
      for (Eigen::Index r = 0; r < n; ++r)
        block(r, c) = std::cos(1.0 + 2.3 * static_cast<double>((r + 1) * (c + 1)) +
                               0.7 * static_cast<double>(r * r % 101));
    Eigen::Index defect = 0;
    block = orthonormal(block);
    for (int step = 0; step < kMostSteps; ++step) {
      block = orthonormal(factor->solve(block));
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(block.transpose() * matrix * block);
      block = (block * ritz.eigenvectors()).eval();
      defect = (ritz.eigenvalues().array() < kZeroEigenvalue).count();
      const double residual = defect > 0 ? (matrix * block.leftCols(defect)).cwiseAbs().maxCoeff() : 0.0;
      if (step > 0 && residual < kZeroEigenvalue * 1e-2) break;
    }
    if (defect < size || size == n) return block.leftCols(defect);
  }
}

}  // namespace

NormalEquations::NormalEquations(const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian,
                                 const std::vector<std::array<int, 3>>& points,
                                 const std::vector<int>& datum) {
  const Sparse by_column = jacobian;
  Sparse normal = by_column.transpose() * by_column;
  const Eigen::Index u = normal.rows();
  const double tiny = std::numeric_limits<double>::min();
  scale_ = Eigen::VectorXd(normal.diagonal()).cwiseMax(tiny).cwiseSqrt().cwiseInverse();
  normal = (scale_.asDiagonal() * normal * scale_.asDiagonal()).eval();
  motions_ = null_space(normal);
  const Eigen::Index d = motions_.cols();
  // The elements between coordinates of a point are in the pattern, so that its covariance is available.
  std::vector<Eigen::Triplet<double>> added;
  for (const std::array<int, 3>& p : points)
    for (const int a : p)
      for (const int b : p)
        if (a >= 0 && b >= 0) added.emplace_back(a, b, 0.0);
  if (d > 0) {
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(motions_.transpose());
    for (Eigen::Index k = 0; k < d; ++k) {
      const int pin = qr.colsPermutation().indices()[k];
      added.emplace_back(pin, pin, 1.0);
    }
  }
  Sparse pins(u, u);
  pins.setFromTriplets(added.begin(), added.end());
  motions_ = (scale_.asDiagonal() * motions_).eval();
  for (Eigen::Index k = 0; k < d; ++k) motions_.col(k).normalize();
  Sparse pinned = normal + pins;
  pinned.makeCompressed();
  factor_ = SparseFactor::of(pinned);
  add_datum(datum);
}

void NormalEquations::add_datum(const std::vector<int>& datum) {
  const Eigen::Index d = motions_.cols();
  if (factor_ == nullptr) {
    for (int c = 0; c < scale_.size(); ++c) undetermined_.push_back(c);
    return;
  }
  constraints_ = Eigen::MatrixXd::Zero(scale_.size(), d);
  if (d == 0) return;
  for (const int c : datum) constraints_.row(c) = motions_.row(c);
  Eigen::FullPivLU<Eigen::MatrixXd> lu(constraints_.transpose() * motions_);
  lu.setThreshold(1e-12);
  if (!lu.isInvertible()) {
    const Eigen::MatrixXd open = motions_ * lu.kernel();
    for (int c = 0; c < open.rows(); ++c)
      if (open.row(c).norm() > kMoves * open.cwiseAbs().maxCoeff()) undetermined_.push_back(c);
    return;
  }
  to_datum_ = motions_ * lu.inverse();
  pinned_constraints_ = solve_pinned(constraints_) * lu.inverse().transpose();
  constraint_cofactors_ = lu.inverse() * constraints_.transpose() * pinned_constraints_;
}

Eigen::MatrixXd NormalEquations::solve_pinned(const Eigen::MatrixXd& right_side) const {
  return scale_.asDiagonal() * factor_->solve(scale_.asDiagonal() * right_side);
}

double NormalEquations::pinned_cofactor(Eigen::Index i, Eigen::Index j) const {
  return scale_[i] * scale_[j] * factor_->inverse(i, j).value_or(0.0);
}

Eigen::VectorXd NormalEquations::solve(const Eigen::VectorXd& right_side,
                                       const Eigen::VectorXd& offset) const {
  Eigen::VectorXd step = solve_pinned(right_side);
  if (defect() > 0) step -= to_datum_ * (constraints_.transpose() * (offset + step));
  return step;
}

Eigen::MatrixXd NormalEquations::cofactors(const std::vector<int>& unknowns) const {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd q(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      q(i, j) = pinned_cofactor(unknowns[static_cast<std::size_t>(i)], unknowns[static_cast<std::size_t>(j)]);
  if (defect() == 0) return q;
  const Eigen::MatrixXd m = motions_(unknowns, Eigen::all), v = pinned_constraints_(unknowns, Eigen::all);
  return q - m * v.transpose() - v * m.transpose() + m * constraint_cofactors_ * m.transpose();
}

double NormalEquations::variance(const Eigen::SparseVector<double>& row) const {
  double sum = 0.0;
  for (Eigen::SparseVector<double>::InnerIterator i(row); i; ++i)
    for (Eigen::SparseVector<double>::InnerIterator j(row); j; ++j)
      sum += i.value() * j.value() * pinned_cofactor(i.index(), j.index());
  return sum;
}

Eigen::MatrixXd NormalEquations::all_cofactors() const {
  const Eigen::Index u = scale_.size();
  Eigen::MatrixXd q = solve_pinned(Eigen::MatrixXd::Identity(u, u));
  if (defect() > 0)
    q += motions_ * constraint_cofactors_ * motions_.transpose() -
         motions_ * pinned_constraints_.transpose() - pinned_constraints_ * motions_.transpose();
  return 0.5 * (q + q.transpose());
}

}  // namespace octant::calib
