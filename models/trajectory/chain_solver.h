// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <utility>

#include <Eigen/Core>

#include "models/support/observed.h"
#include "models/support/parallel.h"
#include "models/support/scratch.h"
#include "models/support/small_cholesky.h"

namespace octant {

/// Normal equations of the states of a segment for fixed shared parameters. They are block-tridiagonal with
/// blocks of fixed size: diagonal blocks D, coupling U to the next state, gradient g.
template <int N>
struct FixedChainSystem {
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;
  double cost = 0.0;  ///< 1/2 sum of rho
  std::pmr::vector<Block> D{scratch()}, U{scratch()};
  std::pmr::vector<Vector> g{scratch()};

  /// Resizes for a number of states. The blocks still have to be cleared.
  void resize(std::size_t count) {
    cost = 0.0;
    D.resize(count);
    U.resize(count);
    g.resize(count);
  }
  void clear(std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      D[k].setZero();
      U[k].setZero();
      g[k].setZero();
    }
  }
};

/// Solves such a system in place: the factors overwrite the blocks, so a long drive stores them only once.
/// States are eliminated from both ends towards the middle, in two threads if the chain is long. This costs
/// no more than elimination from one end, and the step does not depend on the number of threads.
template <int N>
class FixedChainStep {
 public:
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  /// Solves (D + lambda diag D) step = -g. Cost and gradient of the system are kept, its blocks are
  /// overwritten.
  /// @return false if the matrix is not positive definite
  bool solve(FixedChainSystem<N>& system, double lambda, int threads = 1) {
    const std::size_t count = system.D.size(), middle = count > kFromBothEnds ? count / 2 : count - 1;
    const std::size_t halves = middle + 1 < count ? 2 : 1;
    system_ = &system;
    lambda_ = lambda;
    step_.resize(count);
    Passed passed[2];
    for_each_parallel(halves, threads, [&](std::size_t half) {
      passed[half] = half == 0 ? eliminate(0, middle, true) : eliminate(count - 1, middle, false);
    });
    Passed all = passed[0];
    if (halves == 2) all.add(passed[1]);
    SmallCholesky<N> L;
    if (!all.is_definite || !factor(middle, all, L)) return false;
    L.backward(step_[middle]);
    for_each_parallel(halves, threads, [&](std::size_t half) {
      if (half == 0) {
        for (std::size_t k = middle; k-- > 0;) substitute(k, system.U[k], k + 1);
      } else {
        for (std::size_t k = middle + 1; k < count; ++k) substitute(k, system.U[k - 1], k - 1);
      }
    });
    return true;
  }
  [[nodiscard]] const std::pmr::vector<Vector>& step() const { return step_; }
  /// Half the Newton decrement: decrease of a quadratic cost by the step.
  [[nodiscard]] double gain(const FixedChainSystem<N>& system) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < step_.size(); ++k) sum -= 0.5 * system.g[k].dot(step_[k]);
    return sum;
  }

 private:
  static constexpr std::size_t kFromBothEnds =
      512;  ///< shortest chain, in states, for which a second thread pays off

  /// Contribution of eliminated states to the block and right-hand side of their neighbour.
  struct Passed {
    Block D = Block::Zero();
    Vector rhs = Vector::Zero();
    bool is_definite = true;
    void add(const Passed& other) {
      D += other.D;
      rhs += other.rhs;
      is_definite = is_definite && other.is_definite;
    }
  };

  /// Factors a state's block; its right-hand side then becomes L^-1 rhs.
  bool factor(std::size_t k, const Passed& passed, SmallCholesky<N>& L) {
    const Block& D = system_->D[k];
    // The floor keeps an unobserved direction unchanged, such as the heading of a single antenna.
    const double floor = kStepFloor * (1.0 + D.diagonal().maxCoeff());
    Block A = D - passed.D;
    for (int i = 0; i < N; ++i) A(i, i) += lambda_ * D(i, i) + floor;
    if (!L.factor(A)) return false;
    step_[k] = -system_->g[k] - passed.rhs;
    L.forward(step_[k]);
    return true;
  }
  /// Eliminates the states from `first` up to the middle.
  Passed eliminate(std::size_t first, std::size_t middle, bool forth) {
    Passed passed;
    SmallCholesky<N> L;
    for (std::size_t k = first; k != middle; forth ? ++k : --k) {
      passed.is_definite = factor(k, passed, L);
      if (!passed.is_definite) break;
      // Y = (L^-1 U)', column by column, stored in place of U.
      Block& Y = system_->U[forth ? k : k - 1];
      if (forth) Y.transposeInPlace();
      for (int i = 0; i < N; ++i) {
        Vector y = Y.col(i);
        for (int j = 0; j < i; ++j) y -= L.L[i][j] * Y.col(j);
        Y.col(i) = y * L.L[i][i];
      }
      passed.D.noalias() = Y.lazyProduct(Y.transpose());
      passed.rhs.noalias() = Y.lazyProduct(step_[k]);
      for (int i = 0; i < N; ++i)
        for (int j = 0; j <= i; ++j) system_->D[k](i, j) = L.L[i][j];
    }
    return passed;
  }
  /// @param from  the neighbour whose step is known
  void substitute(std::size_t k, const Block& Y, std::size_t from) {
    Vector& step = step_[k];
    step.noalias() -= Y.transpose().lazyProduct(step_[from]);
    const Block& L = system_->D[k];
    for (int i = N; i-- > 0;) {
      step[i] *= L(i, i);
      for (int j = 0; j < i; ++j) step[j] -= L(i, j) * step[i];
    }
  }

  FixedChainSystem<N>* system_ = nullptr;
  double lambda_ = 0.0;
  std::pmr::vector<Vector> step_{scratch()};
};

}  // namespace octant
