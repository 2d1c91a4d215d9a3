// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calib/errors/draw_kernel.h"
#include "calib/errors/error_sample.h"

namespace octant::calib {

/// Mixes the bits of a number (splitmix64).
[[nodiscard]] std::uint64_t mixed_bits(std::uint64_t z);

/// Random bits that are the same on all machines, and values from them.
class DrawBits {
 public:
  explicit DrawBits(std::uint64_t stream) : state_(stream * 0xd1342543de82ef95ULL + 20261122) {}
  [[nodiscard]] std::uint64_t bits();  ///< splitmix64
  /// Approximately normal with variance 1: medians of 4096 equal parts of the distribution.
  void normal(DrawLine& line);

 private:
  std::uint64_t state_;
};

/// Observations of one kind and all their partitions; sums of coarse ones come from the fine ones that they
/// join.
class CellSums {
 public:
  /// @param rows  rows of the sample, in order
  explicit CellSums(std::vector<std::uint32_t> rows) : rows_(std::move(rows)) {}
  /// @param cell  cell of each of these rows  @return number of the partition
  std::size_t add(std::vector<std::int32_t> cell, std::int32_t count);
  /// To be called after all were added.
  void arrange();

  [[nodiscard]] const std::vector<std::uint32_t>& rows() const { return rows_; }
  [[nodiscard]] const std::vector<std::int32_t>& cells(std::size_t partition) const {
    return partitions_[partition].cell;
  }
  [[nodiscard]] std::int32_t count(std::size_t partition) const { return partitions_[partition].count; }

  /// Scratch memory of one thread.
  struct Scratch {
    std::vector<DrawLine> values;
    std::vector<std::vector<DrawLine>> sums;
  };
  /// Squares of the sums over the cells of each partition (rows) for each draw (columns); the last row: sum
  /// over the observations themselves.
  [[nodiscard]] Eigen::MatrixXd squares(const std::vector<DrawLine>& draws, Scratch& scratch) const;

 private:
  struct Partition {
    std::vector<std::int32_t> cell;  ///< cell of each observation
    std::int32_t count = 0;
    int finer = -1;                      ///< partition whose cells it joins, or -1
    std::vector<std::int32_t> of_finer;  ///< cell of each of its cells
  };
  [[nodiscard]] bool joins(const Partition& finer, Partition& coarser) const;

  std::vector<std::uint32_t> rows_;
  std::vector<Partition> partitions_;
  std::vector<std::size_t> order_;  ///< partitions, fine ones first
};

/// Simulated errors of a sample's observations, sixteen draws at a time, and their residuals after an
/// adjustment.
class ErrorDraws {
 public:
  explicit ErrorDraws(const ErrorSample& sample);

  struct Scratch {
    std::vector<DrawLine> shared;
    std::vector<StateLine> states;
  };
  /// Residuals of simulated errors after the adjustment of parameters and states, M e.
  /// @param of_priors  for each shared direction, the contribution of errors of priors to F'e; may be empty
  void adjust(std::vector<DrawLine>& errors, const std::vector<DrawLine>& of_priors, Scratch& scratch) const;
  /// Simulated errors of priors with their given sigmas.
  [[nodiscard]] std::vector<DrawLine> of_priors(std::uint64_t stream) const;
  /// F T.  @param T  rank x at most sixteen
  void influence_times(const Eigen::MatrixXd& T, std::vector<DrawLine>& product) const;
  /// F'Z Z'F. @param rows, cell  rows and cells of some observations
  [[nodiscard]] Eigen::MatrixXd squares_of_cells(const std::vector<std::uint32_t>& rows,
                                                 const std::vector<std::int32_t>& cell,
                                                 std::int32_t count) const;

 private:
  const ErrorSample& sample_;
  std::vector<float> F_;
};

/// A'B, both rows x rank by rows.
[[nodiscard]] Eigen::MatrixXd product_of_rows(const std::vector<float>& A, const std::vector<float>& B,
                                              std::size_t rank);

}  // namespace octant::calib
