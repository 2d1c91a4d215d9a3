// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/priors.h"

#include <algorithm>
#include <cmath>

namespace octant::calib {

DistanceRow distance_row(const ControlDistance& d, const ParameterLayout& layout, const SharedState& state) {
  DistanceRow row;
  const Eigen::Vector3d v = state.beacon_p_map_m[d.from.index()] - state.beacon_p_map_m[d.to.index()];
  const double length = std::max(v.norm(), 1e-9), weight = 1.0 / d.sigma_m;
  row.residual = weight * (length - d.distance_m);
  for (std::size_t i = 0; i < 3; ++i) {
    const double k = weight * v[static_cast<int>(i)] / length;
    if (layout.beacon[d.from.index()][i] >= 0) row.entries.emplace_back(layout.beacon[d.from.index()][i], k);
    if (layout.beacon[d.to.index()][i] >= 0) row.entries.emplace_back(layout.beacon[d.to.index()][i], -k);
  }
  return row;
}

double prior_cost(const Problem& problem, const ParameterLayout& layout, const Eigen::VectorXd& x) {
  double cost = 0.0;
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameters[static_cast<std::size_t>(i)];
    if (std::isfinite(p.prior_sigma)) cost += 0.5 * std::pow((x[i] - p.prior_mean) / p.prior_sigma, 2);
  }
  if (layout.joint_prior) cost += 0.5 * layout.joint_prior->residual(x).squaredNorm();
  const SharedState state = layout.state_of(x);
  for (const ControlDistance& d : problem.site.distances)
    cost += 0.5 * std::pow(distance_row(d, layout, state).residual, 2);
  return cost;
}

void for_each_of_prior(const Problem& problem, const ParameterLayout& layout, const Eigen::VectorXd& x,
                       const std::function<void(int, int, double)>& visit) {
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameters[static_cast<std::size_t>(i)];
    if (std::isfinite(p.prior_sigma)) visit(i, i, 1.0 / (p.prior_sigma * p.prior_sigma));
  }
  if (layout.joint_prior) {
    const JointPrior& prior = *layout.joint_prior;
    const Eigen::MatrixXd N = prior.root.transpose() * prior.root;
    for (std::size_t i = 0; i < prior.columns.size(); ++i)
      for (std::size_t j = 0; j < prior.columns.size(); ++j)
        visit(prior.columns[i], prior.columns[j],
              N(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
  }
  const SharedState state = layout.state_of(x);
  for (const ControlDistance& d : problem.site.distances) {
    const DistanceRow row = distance_row(d, layout, state);
    for (const auto& [i, a] : row.entries)
      for (const auto& [j, b] : row.entries) visit(i, j, a * b);
  }
}

Eigen::MatrixXd prior_information(const Problem& problem, const ParameterLayout& layout,
                                  const Eigen::VectorXd& x) {
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  for_each_of_prior(problem, layout, x, [&](int i, int j, double value) { prior(i, j) += value; });
  return prior;
}

}  // namespace octant::calib
