// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "calib/adjust/tile.h"
#include "calib/problem/shared_entries.h"
#include "models/trajectory/linearise.h"
#include "tests/calib/at_truth.h"

namespace octant::test {

/// A world near its solution: solved states, parameters with small errors.
struct NearTruth : AtTruth {
  calib::ParameterLayout layout;
  Eigen::VectorXd x;
  SharedState here;

  explicit NearTruth(const Scenario& scenario) : AtTruth(scenario, 5) {
    layout = calib::make_layout(problem, state);
    x = layout.vector_of(state);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += 1e-3 * std::sin(3.0 * static_cast<double>(i));
    here = layout.state_of(x);
    for (Trajectory& t : trajectories)
      for (int turn = 0; turn < 3; ++turn)  // to rest, far below what anybody reads
        for (const Segment& s : t.segments) solve_states(t, s, here, {}, 100);
  }

  /// H = Js'Js - Js'Jx (Jx'Jx)^-1 Jx'Js and the gradient, of all rows at once.
  [[nodiscard]] calib::ReducedSystem dense() const {
    Eigen::Index states = 0;
    std::vector<Eigen::Index> first;
    for (const Trajectory& t : trajectories) {
      first.push_back(layout.size() + states);
      states += t.block_size() * static_cast<Eigen::Index>(t.nodes.size());
    }
    const Eigen::Index m = layout.size(), n = m + states;
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
    calib::ReducedSystem out;
    for (std::size_t k = 0; k < trajectories.size(); ++k) {
      const Trajectory& t = trajectories[k];
      const Eigen::Index size = t.block_size();
      for (const Segment& s : t.segments)
        for_each_row(t, s, here, [&](const ObservationRow& row) {
          Eigen::VectorXd a = Eigen::VectorXd::Zero(n);
          const calib::RowEntries e = calib::row_entries(row, t.run, layout, here);
          for (std::size_t i = 0; i < static_cast<std::size_t>(e.count); ++i) a[e.column[i]] += e.value[i];
          const Eigen::Index at = first[k] + size * static_cast<Eigen::Index>(row.node);
          a.segment(at, size) += row.by_node.transpose();
          if (row.has_next) a.segment(at + size, size) += row.by_next.transpose();
          N += a * a.transpose();
          g += row.residual * a;
          out.cost += 0.5 * row.residual * row.residual;
        });
    }
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(N.bottomRightCorner(states, states));
    out.H = N.topLeftCorner(m, m) - N.topRightCorner(m, states) * ldlt.solve(N.bottomLeftCorner(states, m));
    out.gradient = g.head(m) - N.topRightCorner(m, states) * ldlt.solve(g.tail(states));
    return out;
  }
};

inline Scenario some_stops() {
  Scenario s = hall_scenario();
  s.path.epochs = 12;
  return s;
}
inline Scenario short_drive() {
  Scenario s = drive_scenario(3.0);
  s.log_poses = true;
  return s;
}

/// In the scale of each parameter: both lose digits if states absorb most of its information.
inline void expect_same_system(const calib::ReducedSystem& a, const calib::ReducedSystem& b,
                               double tolerance) {
  const Eigen::VectorXd scale = b.H.diagonal().cwiseMax(1e-9).cwiseSqrt().cwiseInverse();
  EXPECT_LT((scale.asDiagonal() * (a.H - b.H) * scale.asDiagonal()).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LT((a.gradient - b.gradient).cwiseProduct(scale).cwiseAbs().maxCoeff(), 10 * tolerance);
  EXPECT_NEAR(a.cost, b.cost, tolerance * b.cost);
}

}  // namespace octant::test
