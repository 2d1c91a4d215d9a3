// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/priors.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <map>

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

Eigen::VectorXd range_residuals_s(const Problem& problem, const SharedState& state) {
  const std::vector<BeaconRange>& pairs = problem.beacon_ranges.pairs;
  Eigen::VectorXd residuals_s(static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const double length_m =
        (state.beacon_p_map_m[pairs[k].from.index()] - state.beacon_p_map_m[pairs[k].to.index()]).norm();
    const double speed_mps = pairs[k].model_speed_mps + state.speed_offset(pairs[k].run);
    residuals_s[static_cast<Eigen::Index>(k)] =
        problem.site.timing.legs() * length_m / speed_mps - pairs[k].tof_s;
  }
  return residuals_s;
}

std::vector<std::pair<ParameterId, double>> range_derivatives(const Problem& problem,
                                                              const SharedState& state,
                                                              const BeaconRange& range) {
  const std::size_t from = range.from.index(), to = range.to.index();
  const Eigen::Vector3d v = state.beacon_p_map_m[from] - state.beacon_p_map_m[to];
  const double length_m = std::max(v.norm(), 1e-9), legs = problem.site.timing.legs(),
               slowness = 1.0 / (range.model_speed_mps + state.speed_offset(range.run));
  std::vector<std::pair<ParameterId, double>> derivatives;
  for (std::size_t i = 0; i < 3; ++i) {
    const double by_m = legs * slowness * v[static_cast<int>(i)] / length_m;
    derivatives.emplace_back(parameters::beacon_position(from, i), by_m);
    derivatives.emplace_back(parameters::beacon_position(to, i), -by_m);
  }
  derivatives.emplace_back(parameters::speed(range.run + 1), -legs * slowness * slowness * length_m);
  return derivatives;
}

namespace {

/// Ranges between beacons, whitened by their covariance with the delays of the beacons.
void add_range_rows(const Problem& problem, const ParameterLayout& layout, const SharedState& state,
                    std::vector<PriorRow>& rows) {
  const std::vector<BeaconRange>& pairs = problem.beacon_ranges.pairs;
  if (pairs.empty()) return;
  std::map<int, int> place;  // index of a column among those that the ranges depend on
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    for (const auto& [id, value] : range_derivatives(problem, state, pairs[k])) {
      const int column = layout.column_of(id);
      if (column < 0) continue;
      const int at = place.emplace(column, static_cast<int>(place.size())).first->second;
      entries.emplace_back(static_cast<int>(k), at, value);
    }
  Eigen::SparseMatrix<double> jacobian(static_cast<Eigen::Index>(pairs.size()),
                                       static_cast<Eigen::Index>(place.size()));
  jacobian.setFromTriplets(entries.begin(), entries.end());
  const Eigen::MatrixXd whitened = problem.beacon_ranges.root * jacobian;
  const Eigen::VectorXd residuals = problem.beacon_ranges.root * range_residuals_s(problem, state);
  for (Eigen::Index k = 0; k < whitened.rows(); ++k) {
    PriorRow& row = rows.emplace_back(PriorRow{residuals[k], {}});
    for (const auto& [column, at] : place)
      row.entries.emplace_back(column, layout.parameter(column).si_per_unit * whitened(k, at));
  }
}

}  // namespace

std::vector<PriorRow> prior_rows(const Problem& problem, const ParameterLayout& layout,
                                 const Eigen::VectorXd& x) {
  std::vector<PriorRow> rows;
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameter(i);
    const double weight = std::isfinite(p.prior_sigma) ? 1.0 / p.prior_sigma : 0.0;
    rows.push_back({weight * (x[i] - p.prior_mean), {{i, weight}}});
  }
  if (!problem.site.distances.empty() || !problem.beacon_ranges.pairs.empty()) {
    const SharedState state = layout.state_of(x);
    for (const ControlDistance& d : problem.site.distances) rows.push_back(distance_row(d, layout, state));
    add_range_rows(problem, layout, state, rows);
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
