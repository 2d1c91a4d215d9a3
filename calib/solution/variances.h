// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/solution/solution.h"

namespace octant::calib {

/// Access by parameters to a solution's joint covariance, or to its marginals if there is no joint one; SI
/// units.
class Variances {
 public:
  /// @param solution  not owned
  explicit Variances(const Solution& solution);
  /// @param covariance  not owned
  explicit Variances(const JointCovariance& covariance);

  /// Returns true if a parameter was free.
  [[nodiscard]] bool has(const ParameterId& id) const { return index_[id] >= 0; }
  /// 0 if one was fixed, or if the pair has no element.
  [[nodiscard]] double covariance(const ParameterId& a, const ParameterId& b) const;
  [[nodiscard]] double sigma(const ParameterId& a) const {
    return std::sqrt(std::max(0.0, covariance(a, a)));
  }
  /// Sigmas of the coordinates of a beacon.
  [[nodiscard]] Eigen::Vector3d beacon_sigma_m(std::size_t beacon) const;

 private:
  const JointCovariance* joint_;
  const MarginalCovariance* marginals_ = nullptr;  ///< used without a joint covariance
  ParameterIndex index_;
};

/// Sigmas of a beacon's coordinates under white errors; no value if its main ones are those.
[[nodiscard]] std::optional<Eigen::Vector3d> white_sigma_m(const Solution& solution, std::size_t beacon);

}  // namespace octant::calib
