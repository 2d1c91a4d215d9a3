// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <utility>

#include <Eigen/Core>

#include "models/support/scratch.h"
#include "models/trajectory/observed.h"

namespace octant {

// Of numbers; kernels have it of their vectors (vector-inl.h).
#include "models/support/small_cholesky.inc"

/// Normal equations of the states of a segment, shared parameters held: block-tridiagonal with blocks of a
/// size known to the compiler; diagonal blocks D, coupling U to the next state, gradient g.
template <int N>
struct FixedChainSystem {
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;
  double cost = 0.0;  ///< 1/2 sum of rho
  std::pmr::vector<Block> D{scratch()}, U{scratch()};
  std::pmr::vector<Vector> g{scratch()};

  void clear(std::size_t count) {
    cost = 0.0;
    D.assign(count, Block::Zero());
    U.assign(count, Block::Zero());
    g.assign(count, Vector::Zero());
  }
};

/// Factors of such a system and the step that they lead to.
template <int N>
class FixedChainStep {
 public:
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  /// Solves (D + lambda diag D) step = -g; false if that is not positive definite.
  bool solve(const FixedChainSystem<N>& system, double lambda) {
    const std::size_t count = system.D.size();
    factor_.resize(count);
    W_.resize(count);
    step_.resize(count);
    Block A = system.D[0];
    Vector rhs = -system.g[0];
    for (std::size_t k = 0;; ++k) {
      // The floor keeps a direction that nothing observes (the heading of a single antenna) where it is.
      const double floor = kStepFloor * (1.0 + system.D[k].diagonal().maxCoeff());
      for (int i = 0; i < N; ++i) A(i, i) += lambda * system.D[k](i, i) + floor;
      if (!factor_[k].factor(A)) return false;
      factor_[k].forward(rhs);
      step_[k] = rhs;
      if (k + 1 == count) break;
      Block& W = W_[k];
      W = system.U[k];
      for (int j = 0; j < N; ++j) factor_[k].forward(W.col(j));
      A = system.D[k + 1];
      rhs = -system.g[k + 1];
      A.noalias() -= W.transpose().lazyProduct(W);
      rhs.noalias() -= W.transpose().lazyProduct(step_[k]);
    }
    factor_[count - 1].backward(step_[count - 1]);
    for (std::size_t k = count - 1; k-- > 0;) {
      step_[k].noalias() -= W_[k].lazyProduct(step_[k + 1]);
      factor_[k].backward(step_[k]);
    }
    return true;
  }
  [[nodiscard]] const std::pmr::vector<Vector>& step() const { return step_; }
  /// Half the Newton decrement: what a quadratic cost would lose by the step.
  [[nodiscard]] double gain(const FixedChainSystem<N>& system) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < step_.size(); ++k) sum -= 0.5 * system.g[k].dot(step_[k]);
    return sum;
  }

 private:
  std::pmr::vector<SmallCholesky<N>> factor_{scratch()};
  std::pmr::vector<Block> W_{scratch()};  ///< L^-1 U
  std::pmr::vector<Vector> step_{scratch()};
};

}  // namespace octant
