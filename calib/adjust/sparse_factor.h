// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace octant::calib {

/// Supernodal Cholesky factor L L' of a sparse positive definite matrix, and its inverse in the pattern of L.
/// With a supernode's diagonal block L11, the block L21 below it, rows P of that, and Z the inverse,
///   Y = L21 L11^-1,   Z21 = -Z_PP Y,   Z11 = (L11 L11')^-1 - Y' Z21,
/// last supernode first; Z_PP stands in the supernodes behind it.
class SparseFactor {
 public:
  /// @param matrix  symmetric, compressed, both triangles stored
  /// @return null where it is not positive definite
  [[nodiscard]] static std::unique_ptr<SparseFactor> of(const Eigen::SparseMatrix<double>& matrix);
  ~SparseFactor();
  SparseFactor(const SparseFactor&) = delete;
  SparseFactor& operator=(const SparseFactor&) = delete;

  /// Smallest pivot squared over the largest: below rounding the matrix is singular.
  [[nodiscard]] double condition() const;
  /// Not from two threads at a time.
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs) const;
  /// Element of the inverse within the pattern.
  [[nodiscard]] std::optional<double> inverse(Eigen::Index i, Eigen::Index j) const;

 private:
  class Parts;
  explicit SparseFactor(std::unique_ptr<Parts> parts);
  void invert();
  [[nodiscard]] Eigen::MatrixXd gather(const std::vector<int>& rows) const;

  std::unique_ptr<Parts> parts_;
};

}  // namespace octant::calib
