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

/// A part with its columns of the layout, ascending.
struct SystemPart {
  std::vector<int> columns;
  ReducedSystem system;
};

/// @param columns  of a new, empty part
[[nodiscard]] SystemPart empty_part(std::vector<int> columns);
/// All columns of a layout with this number of parameters.
[[nodiscard]] std::vector<int> all_columns(int parameters);

/// Sum of a log: several systems, each of which is dense in its own columns. At sites with dense matrices it
/// is one system of all columns.
class SystemParts {
 public:
  SystemParts() = default;
  explicit SystemParts(SystemPart first) { parts_.push_back(std::move(first)); }

  /// Into the part that grows least by it; a part of its own where that takes fewer numbers, up to a limit.
  void add(const SystemPart& part);
  void add(const SystemParts& other);
  /// Rescales costs, gradients and matrices for another noise.
  void scale(double factor);

  [[nodiscard]] double cost() const;
  [[nodiscard]] const std::vector<SystemPart>& parts() const { return parts_; }
  /// The only part with all parameters, created if necessary. It must not be called if there are other parts.
  ReducedSystem& whole_part(int parameters);
  /// All parts in one system with this number of parameters.
  [[nodiscard]] ReducedSystem whole(int parameters) const;

 private:
  std::vector<SystemPart> parts_;
};

}  // namespace octant::calib
