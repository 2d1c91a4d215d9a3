// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/score_test.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include <Eigen/Cholesky>

#include "models/localizers/chain/chain_windows.h"
#include "models/trajectory/stretches.h"

namespace octant::calib {
namespace {

/// Adds the rows of a window after their states have followed each error.
void add_window(const Trajectory& t, const Segment& segment, const SharedState& state,
                const ParameterLayout& layout, const ErrorPatterns& patterns, const ChainWindow& window,
                Eigen::RowVectorXd& by, ScoreTest& test) {
  const Eigen::Index n = t.block_size();
  // Effect of the states of a row's node on its residual. The solution includes the state behind the window.
  const auto moved = [&](std::size_t node, const NodeRow& by_state) -> Eigen::RowVectorXd {
    return by_state.leftCols(n) *
           window.solution.middleRows(static_cast<Eigen::Index>(node - window.first_node) * n, n);
  };
  for_each_row(t, stretch_of(t, segment, window.first_node, window.last_node + 1), state,
               [&](const ObservationRow& row) {
                 by.setZero();
                 static_cast<void>(patterns(t, row, by));
                 by -= moved(row.node, row.by_node);
                 if (row.has_next) by -= moved(row.node + 1, row.by_next);
                 test.add_row(row.residual, row_entries(row, t.run, layout, state), by);
               });
}

void add_segment(const Trajectory& t, const Segment& segment, const SharedState& state,
                 const ParameterLayout& layout, Eigen::Index errors, const ErrorPatterns& patterns,
                 int threads, ScoreTest& test) {
  if (segment.last_node == segment.first_node || !t.nodes[segment.first_node].placed) return;
  Eigen::RowVectorXd by(errors);
  const ChainVariant variant{
      .without = {},
      .columns = errors,
      .errors_of =
          [&](const ObservationRow& row, Eigen::RowVectorXd& of_row) {
            of_row.setZero(errors);
            return patterns(t, row, of_row);
          },
      .visit = [&](const ChainWindow& w) { add_window(t, segment, state, layout, patterns, w, by, test); }};
  static_cast<void>(solve_by_windows(t, segment, state, std::span(&variant, 1), threads));
}

}  // namespace

ScoreTest::ScoreTest(Eigen::Index parameters, Eigen::Index errors)
    : gradient_(Eigen::VectorXd::Zero(errors)), squares_(Eigen::MatrixXd::Zero(errors, errors)) {
  by_parameters_.setZero(parameters, errors);
}

void ScoreTest::add_row(double residual, const RowEntries& shared, const Eigen::RowVectorXd& by) {
  gradient_ += residual * by.transpose();
  squares_.noalias() += by.transpose() * by;
  for (std::size_t i = 0; i < static_cast<std::size_t>(shared.count); ++i)
    by_parameters_.row(shared.column[i]) += shared.value[i] * by;
}

void ScoreTest::add(const ScoreTest& other) {
  gradient_ += other.gradient_;
  squares_ += other.squares_;
  by_parameters_ += other.by_parameters_;
}

Eigen::MatrixXd ScoreTest::information(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                       const Covariance& covariance, double share) const {
  return a.transpose() * squares_ * b - taken_up(a, b, covariance) / share;
}

Eigen::MatrixXd ScoreTest::taken_up(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                    const Covariance& covariance) const {
  Eigen::MatrixXd taken = Eigen::MatrixXd::Zero(a.cols(), b.cols());
  if (by_parameters_.rows() == 0) return taken;
  const Eigen::MatrixXd by = by_parameters_ * b;
  for (Eigen::Index j = 0; j < by.cols(); ++j)
    taken.col(j) = a.transpose() * (by_parameters_.transpose() * covariance.times(by.col(j)));
  return taken;
}

ScoreTest::Finding ScoreTest::of(const Eigen::MatrixXd& sums, const AdjustedParameters& parameters) const {
  constexpr double kLeastLeft = 0.02;
  Finding found{Eigen::VectorXd::Zero(sums.cols())};
  const Eigen::MatrixXd whole = sums.transpose() * squares_ * sums,
                        taken = taken_up(sums, sums, parameters.covariance),
                        left = whole - taken / parameters.share;
  if (!(left.diagonal().array() > kLeastLeft * whole.diagonal().array()).all()) return found;
  const Eigen::VectorXd gradient = sums.transpose() * gradient_;
  found.size = Eigen::LDLT<Eigen::MatrixXd>(left).solve(gradient);
  const Eigen::LDLT<Eigen::MatrixXd> variance(whole - taken);
  const double root = std::sqrt(std::max(0.0, gradient.dot(variance.solve(gradient))));
  found.sigmas = sums.cols() == 1 ? std::copysign(root, found.size[0]) : root;
  return found;
}

Eigen::VectorXd ScoreTest::shift(Eigen::Index error, const Covariance& covariance) const {
  return -covariance.times(by_parameters_.col(error));
}

ScoreTest::Finding ScoreTest::of_error(Eigen::Index error, const AdjustedParameters& parameters) const {
  return of(Eigen::VectorXd::Unit(gradient_.size(), error), parameters);
}

ScoreTest score_test(const std::vector<Trajectory>& trajectories, const SharedState& state,
                     const ParameterLayout& layout, Eigen::Index errors, const ErrorPatterns& patterns,
                     int threads) {
  ScoreTest test(layout.size(), errors);
  for (const Trajectory& t : trajectories)
    for (const Segment& segment : t.segments)
      add_segment(t, segment, state, layout, errors, patterns, threads, test);
  return test;
}

ScoreTest score_test(const Trajectory& trajectory, const Segment& segment, const SharedState& state,
                     const ParameterLayout& layout, Eigen::Index errors, const ErrorPatterns& patterns) {
  ScoreTest test(layout.size(), errors);
  add_segment(trajectory, segment, state, layout, errors, patterns, 1, test);
  return test;
}

}  // namespace octant::calib
