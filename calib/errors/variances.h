// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_map>

#include "calib/solution.h"

namespace octant::calib {

/// Look-up in a solution's joint covariance, or in its marginals where there is none, by names of parameters;
/// SI units.
class Variances {
 public:
  /// @param solution  not owned
  explicit Variances(const Solution& solution);
  /// @param covariance  not owned
  explicit Variances(const JointCovariance& covariance);

  /// Whether a parameter was free.
  [[nodiscard]] bool has(const std::string& name) const { return index_.contains(name); }
  /// 0 where one was held, or the pair is not told.
  [[nodiscard]] double covariance(const std::string& a, const std::string& b) const;
  [[nodiscard]] double sigma(const std::string& a) const {
    return std::sqrt(std::max(0.0, covariance(a, a)));
  }

 private:
  const JointCovariance* joint_;
  const MarginalCovariance* marginals_ = nullptr;  ///< where there is no joint covariance
  std::unordered_map<std::string, Eigen::Index> index_;
};

/// Sigmas of a beacon's coordinates as if errors were white; none where the stated ones are that.
[[nodiscard]] std::optional<Eigen::Vector3d> white_sigma_m(const Solution& solution,
                                                           const std::string& beacon);

}  // namespace octant::calib
