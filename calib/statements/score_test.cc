// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/score_test.h"

#include <cmath>
#include <cstddef>
#include <span>

#include "calib/problem/shared_entries.h"
#include "models/localizers/chain/chain_windows.h"
#include "models/trajectory/stretches.h"

namespace octant::calib {
namespace {

/// What is left of an error beside the parameters, at least.
constexpr double kLeastLeft = 0.02;

/// By the shared parameters: their derivatives times the errors, J'c.
using ByParameters = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Adds what a window's rows say once their states have followed each error.
void add_window(const Trajectory& t, const Segment& segment, const SharedState& state,
                const ParameterLayout& layout, const ErrorPatterns& patterns, const ChainWindow& window,
                ScoreTest& sum, ByParameters& by_parameters) {
  const Eigen::Index n = t.block_size();
  Eigen::RowVectorXd by(sum.gradient.size());
  // Of the row's nodes; in rows of the solution, which has that of the state behind the window too.
  const auto moved = [&](std::size_t node, const NodeRow& by_state) -> Eigen::RowVectorXd {
    return by_state.leftCols(n) *
           window.solution.middleRows(static_cast<Eigen::Index>(node - window.first_node) * n, n);
  };
  for_each_row(t, stretch_of(t, segment, window.first_node, window.last_node + 1), state,
               [&](const ObservationRow& row) {
                 if (!patterns(t, row, by)) by.setZero();
                 by -= moved(row.node, row.by_node);
                 if (row.has_next) by -= moved(row.node + 1, row.by_next);
                 sum.gradient += row.residual * by.transpose();
                 sum.information += by.cwiseAbs2().transpose();
                 const RowEntries shared = row_entries(row, t.run, layout, state);
                 for (int i = 0; i < shared.count; ++i) {
                   const auto k = static_cast<std::size_t>(i);
                   by_parameters.row(shared.column[k]) += shared.value[k] * by;
                 }
               });
}

}  // namespace

double ScoreTest::size(Eigen::Index error) const {
  return information[error] > 0 ? gradient[error] / information[error] : 0.0;
}

double ScoreTest::sigmas(Eigen::Index error) const {
  return information[error] > 0 ? gradient[error] / std::sqrt(information[error]) : 0.0;
}

ScoreTest score_test(const std::vector<Trajectory>& trajectories, const SharedState& state,
                     const AdjustedParameters& parameters, Eigen::Index errors, const ErrorPatterns& patterns,
                     int threads) {
  const ParameterLayout& layout = parameters.layout;
  ScoreTest sum{Eigen::VectorXd::Zero(errors), Eigen::VectorXd::Zero(errors)};
  ByParameters by_parameters = ByParameters::Zero(layout.size(), errors);
  for (const Trajectory& t : trajectories)
    for (const Segment& segment : t.segments) {
      if (segment.last_node == segment.first_node || !t.nodes[segment.first_node].placed) continue;
      const ChainVariant variant{.without = {},
                                 .columns = errors,
                                 .errors_of = [&](const ObservationRow& row,
                                                  Eigen::RowVectorXd& by) { return patterns(t, row, by); },
                                 .visit =
                                     [&](const ChainWindow& w) {
                                       add_window(t, segment, state, layout, patterns, w, sum, by_parameters);
                                     }};
      static_cast<void>(solve_by_windows(t, segment, state, std::span(&variant, 1), threads));
    }
  for (Eigen::Index e = 0; e < errors && layout.size() > 0; ++e) {
    const Eigen::VectorXd by = by_parameters.col(e);
    const double left = sum.information[e] - by.dot(parameters.covariance.times(by));
    sum.information[e] = left > kLeastLeft * sum.information[e] ? left : 0.0;
  }
  return sum;
}

}  // namespace octant::calib
