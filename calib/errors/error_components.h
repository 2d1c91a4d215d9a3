// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "calib/errors/error_draws.h"
#include "calib/errors/error_part.h"
#include "calib/errors/error_sample.h"

namespace octant::calib {

/// Number of observations of a kind below which its errors are not estimated.
inline constexpr std::size_t kFewestObservations = 30;

/// White noise of one kind of observation is the component whose cells are the observations.
struct ErrorComponent {
  ErrorPart part;                       ///< not for white noise
  std::vector<std::size_t> partitions;  ///< index in the sums of its kind; no value: white
  bool bearings = false;
  [[nodiscard]] bool is_white() const { return partitions.empty(); }
};

/// Components that errors of a sample may have, those of white noise first; their draws and sums.
class ErrorComponents {
 public:
  /// @param sample  not owned
  explicit ErrorComponents(const ErrorSample& sample);

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(all_.size()); }
  [[nodiscard]] Eigen::Index whites() const { return whites_; }
  [[nodiscard]] Eigen::Index white_of(bool bearings) const { return whites_ > 1 && bearings ? 1 : 0; }
  [[nodiscard]] const ErrorComponent& operator[](Eigen::Index m) const {
    return all_[static_cast<std::size_t>(m)];
  }
  [[nodiscard]] const std::vector<std::uint32_t>& rows_of(bool bearings) const {
    return sums_[bearings].rows();
  }
  [[nodiscard]] std::size_t count(bool bearings) const { return rows_of(bearings).size(); }
  /// Number of cells of a partition of the component; a white one has one for each observation.
  [[nodiscard]] std::size_t cells_of(Eigen::Index m) const;
  /// Removes all others. @param kept  ascending
  void keep(const std::vector<Eigen::Index>& kept);

  /// Adds normal errors of one component, sixteen draws.
  /// @param draw  selects the partition
  void add_normal(Eigen::Index m, double sigma, std::size_t draw, DrawBits& random,
                  std::vector<DrawLine>& errors) const;
  /// Plus or minus one in each cell of a component (Hutchinson's draws), in one of sixteen columns.
  void set_signs(Eigen::Index m, std::size_t draw, std::size_t column, DrawBits& random,
                 std::vector<DrawLine>& errors) const;
  /// Sums of squares of all components (rows) for each draw (columns): |Z'r|^2, averaged over partitions.
  using Scratch = std::array<CellSums::Scratch, 2>;
  [[nodiscard]] Eigen::MatrixXd sums_of(const std::vector<DrawLine>& r, Scratch& scratch) const;
  /// F'Z Z'F of a component, averaged over partitions.
  [[nodiscard]] Eigen::MatrixXd squares_of_influence(Eigen::Index m, const ErrorDraws& draws) const;

 private:
  /// Calls put(row, value) for each row of a component: rows in one cell share one result of next().
  template <class Next, class Put>
  void draw_cells(const ErrorComponent& c, std::size_t draw, Next&& next, Put&& put) const;

  std::array<CellSums, 2> sums_;  ///< sums of arrivals, of bearings
  std::vector<ErrorComponent> all_;
  Eigen::Index whites_ = 0;
};

}  // namespace octant::calib
