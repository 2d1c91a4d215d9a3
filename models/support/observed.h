// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "models/support/unit_diagonal.h"

namespace octant {

// Test of which directions of a state an information matrix determines. Its elements differ by the squares of
// metres and radians, so the matrix is first scaled to a unit diagonal. The smallest pivot is then the share
// of a direction's information that remains after eliminating the other directions. This rule applies to all
// states and poses. Sums over hundreds of parameters, where rounding matters more, use
// calib/adjust/covariance.h.

/// A direction with at most this share of its information is unobserved.
inline constexpr double kUnobserved = 1e-10;

/// Regularisation of an unobserved state's step, as a share of the largest element of its block.
inline constexpr double kStepFloor = 1e-9;

/// L D L' factorisation of an information matrix scaled to a unit diagonal.
template <class Matrix>
class ObservedState {
 public:
  explicit ObservedState(const Matrix& information) : ObservedState(UnitDiagonal<Matrix>(information)) {}

  /// Returns true if all directions are observed.
  [[nodiscard]] bool all() const {
    const auto pivots = factor_.vectorD();
    return factor_.info() == Eigen::Success && (pivots.array() > kUnobserved).all();
  }
  /// Valid only if all directions are observed.
  [[nodiscard]] Matrix covariance() const {
    return solve(Matrix::Identity(factor_.rows(), factor_.cols()).eval());
  }
  template <class Right>
  [[nodiscard]] Right solve(const Right& right) const {
    const Right scaled = inverse_scale_.asDiagonal() * right;
    return inverse_scale_.asDiagonal() * factor_.solve(scaled).eval();
  }

 private:
  explicit ObservedState(const UnitDiagonal<Matrix>& information)
      : inverse_scale_(information.inverse_scale), factor_(information.scaled) {}

  typename UnitDiagonal<Matrix>::Vector inverse_scale_;
  Eigen::LDLT<Matrix> factor_;
};

}  // namespace octant
