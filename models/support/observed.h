// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "models/support/unit_diagonal.h"

namespace octant {

// What an information matrix tells of a state, and what it does not. Its elements differ by the squares of
// metres and radians, so it is judged scaled to a unit diagonal, where the smallest pivot is the share of a
// direction's information that the others leave to it. This is the one rule for states and poses; sums over
// hundreds of parameters, where rounding is nearer, have calib/adjust/covariance.h.

/// A direction whose share is not more than this is unobserved.
inline constexpr double kUnobserved = 1e-10;

/// What a step of a state that nothing observes is held by, as a share of its block's largest element.
inline constexpr double kStepFloor = 1e-9;

/// L D L' of an information matrix scaled to a unit diagonal.
template <class Matrix>
class ObservedState {
 public:
  explicit ObservedState(const Matrix& information) : ObservedState(UnitDiagonal<Matrix>(information)) {}

  /// Whether all directions are observed.
  [[nodiscard]] bool all() const {
    const auto pivots = factor_.vectorD();
    return factor_.info() == Eigen::Success && (pivots.array() > kUnobserved).all();
  }
  /// Of use where all are.
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
