// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/variances.h"

namespace octant::calib {

Variances::Variances(const Solution& solution) : solution_(solution) {
  const auto& names = solution.covariance.parameters.empty() ? solution.marginals.parameters : solution.covariance.parameters;
  for (std::size_t i = 0; i < names.size(); ++i) index_[names[i]] = static_cast<Eigen::Index>(i);
}

double Variances::covariance(const std::string& a, const std::string& b) const {
  const auto i = index_.find(a), j = index_.find(b);
  if (i == index_.end() || j == index_.end()) return 0.0;
  return solution_.covariance.parameters.empty() ? solution_.marginals.matrix.coeff(i->second, j->second)
                                                 : solution_.covariance.matrix(i->second, j->second);
}

}  // namespace octant::calib
