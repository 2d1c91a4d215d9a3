// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/variances.h"

namespace octant::calib {

Variances::Variances(const Solution& solution) : Variances(solution.covariance) {
  if (!joint_->parameters.empty()) return;
  marginals_ = &solution.marginals;
  for (std::size_t i = 0; i < marginals_->parameters.size(); ++i)
    index_[marginals_->parameters[i]] = static_cast<Eigen::Index>(i);
}

Variances::Variances(const JointCovariance& covariance) : joint_(&covariance) {
  for (std::size_t i = 0; i < covariance.parameters.size(); ++i)
    index_[covariance.parameters[i]] = static_cast<Eigen::Index>(i);
}

double Variances::covariance(const ParameterId& a, const ParameterId& b) const {
  const auto i = index_.find(a), j = index_.find(b);
  if (i == index_.end() || j == index_.end()) return 0.0;
  return marginals_ != nullptr ? marginals_->matrix.coeff(i->second, j->second)
                               : joint_->matrix(i->second, j->second);
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
