// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/solution/solution.h"

namespace octant::calib {

/// Look-up in a solution's joint covariance, or in its marginals where there is none, by parameters; SI
/// units.
class Variances {
 public:
  /// @param solution  not owned
  explicit Variances(const Solution& solution);
  /// @param covariance  not owned
  explicit Variances(const JointCovariance& covariance);

  /// Whether a parameter was free.
  [[nodiscard]] bool has(const ParameterId& id) const { return index_[id] >= 0; }
  /// 0 where one was held, or the pair is not told.
  [[nodiscard]] double covariance(const ParameterId& a, const ParameterId& b) const;
  [[nodiscard]] double sigma(const ParameterId& a) const {
    return std::sqrt(std::max(0.0, covariance(a, a)));
  }
  /// Of the coordinates of a beacon.
  [[nodiscard]] Eigen::Vector3d beacon_sigma_m(std::size_t beacon) const;

 private:
  const JointCovariance* joint_;
  const MarginalCovariance* marginals_ = nullptr;  ///< where there is no joint covariance
  ParameterIndex index_;
};

/// Sigmas of a beacon's coordinates as if errors were white; none where the stated ones are that.
[[nodiscard]] std::optional<Eigen::Vector3d> white_sigma_m(const Solution& solution, std::size_t beacon);

}  // namespace octant::calib
