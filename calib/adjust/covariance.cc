// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/covariance.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include <Eigen/Eigenvalues>

#include "calib/adjust/sparse_factor.h"
#include "models/support/decompositions.h"
#include "models/support/unit_diagonal.h"

namespace octant::calib {
namespace {

/// Below this eigenvalue of the matrix scaled to a unit diagonal a direction counts as unseen.
constexpr double kUnobservable = 1e-12;
/// Lanczos: the largest variances stand out, and the space is then complete long before.
constexpr Eigen::Index kMostSteps = 150;
constexpr double kConverged = 1e-6;
/// Sigma of a parameter without information: a thousand kilometres.
constexpr double kNoInformation = 1e-12;

/// The remaining information on an unobservable parameter is a rounding error and may be negative: such a
/// parameter is then separated and treated as unknown.
void separate_unobservable(Eigen::MatrixXd& N) {
  for (Eigen::Index i = 0; i < N.rows(); ++i) {
    if (N(i, i) > 0) continue;
    N.row(i).setZero();
    N.col(i).setZero();
    N(i, i) = kNoInformation;
  }
}

void separate_unobservable(Eigen::SparseMatrix<double>& N) {
  const Eigen::VectorXd before = N.diagonal();
  if ((before.array() > 0).all()) return;
  N.prune([&](Eigen::Index i, Eigen::Index j, double) { return i == j || (before[i] > 0 && before[j] > 0); });
  for (Eigen::Index i = 0; i < before.size(); ++i)
    if (!(before[i] > 0)) N.coeffRef(i, i) = kNoInformation;
}

Eigen::MatrixXd dense_inverse(const Eigen::MatrixXd& information, const Eigen::MatrixXd& datum) {
  if (information.rows() == 0) return information;
  Eigen::MatrixXd N = information;
  const double weight = datum.cols() > 0 ? information.diagonal().mean() : 0.0;
  if (datum.cols() > 0) N += weight * datum * datum.transpose();
  separate_unobservable(N);
  const UnitDiagonal<Eigen::MatrixXd> unit(N);
  const SymmetricEigen<Eigen::MatrixXd> eigen(unit.scaled);
  Eigen::MatrixXd C =
      unit.inverse(eigen.eigenvectors(), eigen.eigenvalues().cwiseMax(kUnobservable).cwiseInverse());
  if (datum.cols() > 0) C -= datum * datum.transpose() / weight;
  return 0.5 * (C + C.transpose());
}

/// A vector that no eigenvector is orthogonal to but by accident, always the same.
Eigen::VectorXd any_vector(Eigen::Index n) {
  Eigen::VectorXd v(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = std::sin(1.0 + 1.6180339887 * static_cast<double>(i)) + 0.1;
  return v;
}

}  // namespace

class Covariance::Sparse {
 public:
  Sparse(Eigen::SparseMatrix<double> N, const Eigen::MatrixXd& datum) : datum_(datum) {
    if (datum.cols() > 0) pin(N);
    separate_unobservable(N);
    inverse_scale_ = Eigen::VectorXd(N.diagonal()).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const auto scale = inverse_scale_.asDiagonal();
    N = (scale * N * scale).eval();
    factor_ = SparseFactor::of(N);
    if (!factor_ || factor_->condition() < kUnobservable) {
      Eigen::SparseMatrix<double> floor(N.rows(), N.cols());
      floor.setIdentity();
      factor_.reset();
      for (double floor_share = kUnobservable; !factor_ && floor_share < 1.0; floor_share *= 10)
        factor_ = SparseFactor::of(N + floor_share * floor);
    }
    if (datum.cols() == 0 || !factor_) return;
    pinned_ = solve(datum);
    inner_ = datum.transpose() * pinned_;
  }

  [[nodiscard]] Eigen::Index size() const { return inverse_scale_.size(); }
  [[nodiscard]] const SparseFactor* factor() const { return factor_.get(); }

  [[nodiscard]] double at(Eigen::Index i, Eigen::Index j) const {
    if (!factor_) return NAN;  // the information is no number
    const auto known = factor_->inverse(i, j);
    if (known) return shifted(i, j, *known);
    const std::lock_guard lock(mutex_);
    return times(Eigen::VectorXd::Unit(size(), j))(i, 0);
  }
  /// Element of the free network's covariance, from that of the scaled and pinned one.
  [[nodiscard]] double shifted(Eigen::Index i, Eigen::Index j, double element) const {
    const double c = inverse_scale_[i] * element * inverse_scale_[j];
    if (datum_.cols() == 0) return c;
    return c - datum_.row(i).dot(pinned_.row(j)) - pinned_.row(i).dot(datum_.row(j)) +
           (datum_.row(i) * inner_).dot(datum_.row(j));
  }
  [[nodiscard]] Eigen::MatrixXd times(const Eigen::MatrixXd& v) const {
    if (!factor_) return Eigen::MatrixXd::Constant(v.rows(), v.cols(), NAN);
    if (datum_.cols() == 0) return solve(v);
    const Eigen::MatrixXd x = solve(v - datum_ * (datum_.transpose() * v));
    return x - datum_ * (datum_.transpose() * x);
  }
  [[nodiscard]] std::mutex& mutex() const { return mutex_; }

 private:
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& v) const {
    return inverse_scale_.asDiagonal() * factor_->solve(inverse_scale_.asDiagonal() * v);
  }
  /// Fixes as many parameters as the datum has degrees of freedom: those that it moves most.
  void pin(Eigen::SparseMatrix<double>& N) const {
    const PivotedQr qr(datum_.transpose());
    const double weight = N.diagonal().mean();
    for (Eigen::Index k = 0; k < datum_.cols(); ++k) {
      const Eigen::Index i = qr.colsPermutation().indices()[k];
      N.coeffRef(i, i) += weight;
    }
  }

  Eigen::MatrixXd datum_, pinned_, inner_;  ///< F, C F, F' C F
  Eigen::VectorXd inverse_scale_;
  std::unique_ptr<SparseFactor> factor_;
  mutable std::mutex mutex_;  ///< the factor solves for one at a time
};

Covariance::Covariance() = default;
Covariance::Covariance(Eigen::MatrixXd matrix) : matrix_(std::move(matrix)) {}
Covariance::Covariance(const Eigen::MatrixXd& information, const Eigen::MatrixXd& datum)
    : matrix_(dense_inverse(information, datum)) {}
Covariance::Covariance(const Eigen::SparseMatrix<double>& information, const Eigen::MatrixXd& datum)
    : sparse_(std::make_shared<const Sparse>(information, datum)) {}

Eigen::Index Covariance::size() const { return sparse_ ? sparse_->size() : matrix_.rows(); }
const Eigen::MatrixXd* Covariance::matrix() const { return sparse_ ? nullptr : &matrix_; }

bool Covariance::all_finite() const {
  for (Eigen::Index i = 0; i < size(); ++i)
    if (!std::isfinite((*this)(i, i))) return false;
  return sparse_ || matrix_.allFinite();
}

double Covariance::operator()(Eigen::Index i, Eigen::Index j) const {
  return sparse_ ? sparse_->at(i, j) : matrix_(i, j);
}

Eigen::MatrixXd Covariance::block(std::span<const int> columns) const {
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      if (const int a = columns[static_cast<std::size_t>(i)], b = columns[static_cast<std::size_t>(j)];
          a >= 0 && b >= 0)
        C(i, j) = C(j, i) = (*this)(a, b);
  return C;
}

Eigen::VectorXd Covariance::times(const Eigen::VectorXd& v) const {
  if (!sparse_) return matrix_ * v;
  const std::lock_guard lock(sparse_->mutex());
  return sparse_->times(v);
}

Eigen::MatrixXd Covariance::columns(const std::vector<int>& columns) const {
  Eigen::MatrixXd which = Eigen::MatrixXd::Zero(size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k)
    if (sparse_)
      which(columns[k], static_cast<Eigen::Index>(k)) = 1.0;
    else
      which.col(static_cast<Eigen::Index>(k)) = matrix_.col(columns[k]);
  if (!sparse_) return which;
  const std::lock_guard lock(sparse_->mutex());
  return sparse_->times(which);
}

std::vector<Covariance::Direction> Covariance::largest(const Eigen::VectorXd& weights, std::size_t most,
                                                       double least) const {
  std::vector<Direction> directions;
  const Eigen::Index n = size();
  if (!sparse_) {
    const SymmetricEigen<Eigen::MatrixXd> eigen(weights.asDiagonal() * matrix_ * weights.asDiagonal());
    for (Eigen::Index k = n - 1; k >= 0 && directions.size() < most && eigen.eigenvalues()[k] >= least; --k)
      directions.push_back({eigen.eigenvalues()[k], eigen.eigenvectors().col(k)});
    return directions;
  }
  const Eigen::Index steps = std::min(n, kMostSteps);
  Eigen::MatrixXd Q(n, steps);
  Eigen::VectorXd diagonal(steps), beside(steps);
  Q.col(0) = weights.cwiseProduct(any_vector(n)).normalized();
  for (Eigen::Index m = 0; m < steps; ++m) {
    Eigen::VectorXd w = weights.cwiseProduct(times(weights.cwiseProduct(Q.col(m))));
    diagonal[m] = Q.col(m).dot(w);
    for (int again = 0; again < 2; ++again)
      w -= (Q.leftCols(m + 1) * (Q.leftCols(m + 1).transpose() * w)).eval();
    beside[m] = w.norm();
    const bool last = m + 1 == steps || !(beside[m] > 0);
    if (!last) Q.col(m + 1) = w / beside[m];
    if (!last && m % 10 != 9) continue;
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
    eigen.computeFromTridiagonal(diagonal.head(m + 1), beside.head(m));
    // |W C W y - theta y| of a Ritz vector y = Q s is beside_m |s_m|; the error of theta is of second order
    // in it.
    bool converged = true;
    for (Eigen::Index k = m; k >= 0 && m - k < static_cast<Eigen::Index>(most); --k) {
      converged = converged &&
                  beside[m] * std::abs(eigen.eigenvectors()(m, k)) <= kConverged * eigen.eigenvalues()[k];
      if (eigen.eigenvalues()[k] < least) break;
    }
    if (!last && !converged) continue;
    for (Eigen::Index k = m; k >= 0 && directions.size() < most && eigen.eigenvalues()[k] >= least; --k)
      directions.push_back(
          {eigen.eigenvalues()[k], (Q.leftCols(m + 1) * eigen.eigenvectors().col(k)).normalized()});
    break;
  }
  return directions;
}

}  // namespace octant::calib
