// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace octant::calib {

/// Cost, gradient and Gauss-Newton matrix of some observations in the shared parameters they touch, vehicle
/// states eliminated.
struct ReducedSystem {
  double cost = 0.0;  ///< 1/2 sum of rho
  Eigen::VectorXd gradient;
  Eigen::MatrixXd H;
};

/// The same with its columns of the layout, ascending.
struct SystemPart {
  std::vector<int> columns;
  ReducedSystem system;
};

/// @param columns  of a part that nothing was added to yet
[[nodiscard]] SystemPart empty_part(std::vector<int> columns);
/// All of a layout of so many parameters.
[[nodiscard]] std::vector<int> all_columns(int parameters);

/// What a log leaves of itself: a sum of systems, each of which is dense in the columns that it touches.
/// Where the matrices of a site are dense that is one of all columns.
class SystemParts {
 public:
  SystemParts() = default;
  explicit SystemParts(SystemPart first) { parts_.push_back(std::move(first)); }

  /// Into the part that grows least by it; a part of its own where that takes fewer numbers, up to a limit.
  void add(const SystemPart& part);
  void add(const SystemParts& other);
  /// Noise is another: costs, gradients and matrices are so many times what they were.
  void scale(double factor);

  [[nodiscard]] double cost() const;
  [[nodiscard]] const std::vector<SystemPart>& parts() const { return parts_; }
  /// The one part of all of so many parameters, made where there is none: not to be called where others are.
  ReducedSystem& whole_part(int parameters);
  /// All parts in one system of so many parameters.
  [[nodiscard]] ReducedSystem whole(int parameters) const;

 private:
  std::vector<SystemPart> parts_;
};

}  // namespace octant::calib
