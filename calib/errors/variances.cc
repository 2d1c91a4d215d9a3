// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/variances.h"

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

std::optional<Eigen::Vector3d> white_sigma_m(const Solution& solution, std::size_t beacon) {
  if (solution.white_covariance.parameters.empty()) return std::nullopt;
  const Variances white(solution.white_covariance);
  Eigen::Vector3d sigma_m;
  for (std::size_t i = 0; i < 3; ++i)
    sigma_m[static_cast<Eigen::Index>(i)] = white.sigma(parameters::beacon_position(beacon, i));
  return sigma_m;
}

}  // namespace octant::calib
