// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/priors.h"

#include <algorithm>
#include <cmath>

namespace octant::calib {

PriorRow distance_row(const ControlDistance& d, const ParameterLayout& layout, const SharedState& state) {
  PriorRow row;
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

std::vector<PriorRow> prior_rows(const Problem& problem, const ParameterLayout& layout,
                                 const Eigen::VectorXd& x) {
  std::vector<PriorRow> rows;
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameter(i);
    const double weight = std::isfinite(p.prior_sigma) ? 1.0 / p.prior_sigma : 0.0;
    rows.push_back({weight * (x[i] - p.prior_mean), {{i, weight}}});
  }
  if (!problem.site.distances.empty()) {
    const SharedState state = layout.state_of(x);
    for (const ControlDistance& d : problem.site.distances) rows.push_back(distance_row(d, layout, state));
  }
  if (!layout.joint_prior) return rows;
  const JointPrior& prior = *layout.joint_prior;
  const Eigen::VectorXd residual = prior.residual(x);
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    PriorRow& row = rows.emplace_back(PriorRow{residual[i], {}});
    for (std::size_t k = 0; k < prior.columns.size(); ++k)
      row.entries.emplace_back(prior.columns[k], prior.root(i, static_cast<Eigen::Index>(k)));
  }
  return rows;
}

double prior_cost(const Problem& problem, const ParameterLayout& layout, const Eigen::VectorXd& x) {
  double cost = 0.0;
  for (const PriorRow& row : prior_rows(problem, layout, x)) cost += 0.5 * row.residual * row.residual;
  return cost;
}

void for_each_of_prior(const Problem& problem, const ParameterLayout& layout, const Eigen::VectorXd& x,
                       const std::function<void(int, int, double)>& visit) {
  const std::vector<PriorRow> rows = prior_rows(problem, layout, x);
  for (int i = 0; i < layout.size(); ++i)
    if (const double sigma = layout.parameter(i).prior_sigma; std::isfinite(sigma))
      visit(i, i, 1.0 / (sigma * sigma));
  for (std::size_t r = layout.parameters.size(); r < rows.size(); ++r)
    for (const auto& [i, a] : rows[r].entries)
      for (const auto& [j, b] : rows[r].entries)
        if (a != 0.0 && b != 0.0) visit(i, j, a * b);
}

Eigen::MatrixXd prior_information(const Problem& problem, const ParameterLayout& layout,
                                  const Eigen::VectorXd& x) {
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  for_each_of_prior(problem, layout, x, [&](int i, int j, double value) { prior(i, j) += value; });
  return prior;
}

}  // namespace octant::calib
