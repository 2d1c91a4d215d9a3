// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/solution/variances.h"

namespace octant::calib {

Variances::Variances(const Solution& solution) : Variances(solution.covariance) {
  if (!joint_->parameters.empty()) return;
  marginals_ = &solution.marginals;
  index_ = ParameterIndex(marginals_->parameters);
}

Variances::Variances(const JointCovariance& covariance)
    : joint_(&covariance), index_(covariance.parameters) {}

double Variances::covariance(const ParameterId& a, const ParameterId& b) const {
  const int i = index_[a], j = index_[b];
  if (i < 0 || j < 0) return 0.0;
  return marginals_ != nullptr ? marginals_->matrix.coeff(i, j) : joint_->matrix(i, j);
}

Eigen::Vector3d Variances::beacon_sigma_m(std::size_t beacon) const {
  return {sigma(parameters::beacon_position(beacon, 0)), sigma(parameters::beacon_position(beacon, 1)),
          sigma(parameters::beacon_position(beacon, 2))};
}

std::optional<Eigen::Vector3d> white_sigma_m(const Solution& solution, std::size_t beacon) {
  if (solution.white_covariance.parameters.empty()) return std::nullopt;
  return Variances(solution.white_covariance).beacon_sigma_m(beacon);
}

}  // namespace octant::calib
