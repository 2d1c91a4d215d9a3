// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/chain/chain_protection.h"

#include <algorithm>
#include <cmath>

#include "models/localizers/common/protection.h"

namespace octant {

ChainVariant DriveSeparation::without(BeaconId beacon) {
  const auto minus_residual = [](const ObservationRow& row, Eigen::RowVectorXd& errors) {
    errors[0] = -row.residual;
    return true;
  };
  return {beacon, 1, minus_residual, [this](const ChainWindow& window) {
            for_each_instant(window, instants_, [&](std::size_t i) {
              const double shift_m = window.solution_at(instants_[i], dof_).topRows<2>().norm();
              const double sigma_m =
                  std::sqrt(widened_[i] * horizontal_variance(window.covariance_at(instants_[i], dof_)));
              if (!(shift_m <= kAtFaultSigmas * sigma_m)) bounded_[i] = 0;
              worst_m_[i] = std::max(worst_m_[i], shift_m + kFaultySigmas * sigma_m);
            });
          }};
}

double DriveSeparation::level_m(std::size_t instant, double variance_m2) const {
  return bounded_[instant] ? protection_level_m(variance_m2, worst_m_[instant]) : 0.0;
}

}  // namespace octant
