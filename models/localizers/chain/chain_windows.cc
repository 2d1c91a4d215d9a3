// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/chain/chain_windows.h"

#include <algorithm>
#include <utility>

#include "models/localizers/chain/chain_factor.h"
#include "models/support/parallel.h"
#include "models/trajectory/stretches.h"

namespace octant {
namespace {

/// Solves one variant, one window at a time.
class VariantSolver {
 public:
  VariantSolver(const ChainVariant& variant, const Trajectory& t, std::size_t windows)
      : variant_(variant), n_(t.block_size()), errors_(variant.columns), entering_(windows) {
    entering_[0].D = NodeBlock::Zero(n_, n_);
    // The attitude may be unobserved, as for a single antenna on a straight path. It then gets the variance
    // of an unknown angle.
    if (t.motion == Motion::kSpatial) add_vague_angles(t.motion, entering_[0].D);
    entering_[0].x = ChainWindow::Matrix::Zero(n_, variant.columns);
  }
  [[nodiscard]] bool is_determined() const { return is_determined_; }

  /// @param behind  true if there is a state behind the window
  void begin(std::size_t index, std::size_t first_node, std::size_t last_node, bool behind) {
    index_ = index;
    window_.first_node = first_node;
    window_.last_node = last_node;
    const std::size_t nodes = own() + (behind ? 1 : 0);
    system_.clear(nodes, n_);
    window_.solution.setZero(static_cast<Eigen::Index>(nodes) * n_, variant_.columns);
  }
  void add(const ObservationRow& row) {
    const bool is_arrival = row.kind == RowKind::kTof || row.kind == RowKind::kAmplitude;
    if (!is_determined_ || (is_arrival && row.beacon == variant_.without)) return;
    system_.add(row, window_.first_node, RobustLoss{});
    if (variant_.columns == 0 || !variant_.errors_of(row, errors_)) return;
    const std::size_t k = row.node - window_.first_node;
    for (int i = 0; i < n_; ++i) {
      solution(k).row(i) += row.by_node[i] * errors_;
      if (row.has_next) solution(k + 1).row(i) += row.by_next[i] * errors_;
    }
  }
  void eliminate() {
    if (!is_determined_) return;
    system_.D[0] += entering_[index_].D;
    solution(0) += entering_[index_].x;
    is_determined_ = eliminate_states(system_, own(), inverse_);
    if (!is_determined_) return;
    for (std::size_t k = 0; k + 1 < system_.D.size(); ++k)
      solution(k + 1) -= system_.U[k].transpose() * (inverse_[k] * solution(k));
  }
  void pass_on() {
    if (is_determined_) entering_[index_ + 1] = {system_.D.back(), solution(own())};
  }
  /// Back substitution, starting from the state behind the window if there is one.
  void substitute() {
    window_.marginal.resize(system_.D.size());
    window_.cross.resize(system_.D.size() - 1);
    if (own() < system_.D.size()) {
      window_.marginal.back() = covariance_behind_;
      solution(own()) = solution_behind_;
    }
    for (std::size_t k = own(); k-- > 0;) {
      window_.marginal[k] = inverse_[k];
      if (k + 1 < system_.D.size()) {
        const NodeBlock gain = inverse_[k] * system_.U[k];
        window_.cross[k] = -gain * window_.marginal[k + 1];
        window_.marginal[k] += gain * window_.marginal[k + 1] * gain.transpose();
        solution(k) -= system_.U[k] * solution(k + 1);
      }
      solution(k) = (inverse_[k] * solution(k)).eval();
    }
    covariance_behind_ = window_.marginal.front();
    solution_behind_ = solution(0);
  }
  void visit() const { variant_.visit(window_); }

 private:
  /// Schur complement of the states before a window on its first state.
  struct Entering {
    NodeBlock D;
    ChainWindow::Matrix x;
  };
  [[nodiscard]] std::size_t own() const { return window_.last_node - window_.first_node; }
  [[nodiscard]] Eigen::Block<ChainWindow::Matrix, Eigen::Dynamic, Eigen::Dynamic, true> solution(
      std::size_t k) {
    return window_.solution.middleRows(static_cast<Eigen::Index>(k) * n_, n_);
  }

  const ChainVariant& variant_;
  int n_;
  Eigen::RowVectorXd errors_;
  std::vector<Entering> entering_;
  bool is_determined_ = true;
  std::size_t index_ = 0;
  ChainSystem system_;
  std::pmr::vector<NodeBlock> inverse_{scratch()};
  ChainWindow window_;
  NodeBlock covariance_behind_;
  ChainWindow::Matrix solution_behind_;
};

/// Components of the two nodes of an instant, with their weights.
struct Between {
  std::size_t k = 0;
  double alpha = 0.0;
  Between(const ChainWindow& w, const DriveInstant& instant)
      : k(instant.node - w.first_node), alpha(k + 1 < w.marginal.size() ? instant.alpha : 0.0) {}
};

}  // namespace

NodeBlock ChainWindow::covariance_at(const DriveInstant& instant, int dof) const {
  const auto [k, alpha] = Between(*this, instant);
  if (alpha == 0.0) return marginal[k].topLeftCorner(dof, dof);
  const NodeBlock P = (1 - alpha) * (1 - alpha) * marginal[k] + alpha * alpha * marginal[k + 1] +
                      alpha * (1 - alpha) * (cross[k] + cross[k].transpose());
  return P.topLeftCorner(dof, dof);
}

ChainWindow::Matrix ChainWindow::solution_at(const DriveInstant& instant, int dof) const {
  const auto [k, alpha] = Between(*this, instant);
  const Eigen::Index n = marginal[k].rows(), at = static_cast<Eigen::Index>(k) * n;
  Matrix x = (1.0 - alpha) * solution.middleRows(at, dof);
  if (alpha > 0.0) x += alpha * solution.middleRows(at + n, dof);
  return x;
}

std::vector<bool> solve_by_windows(const Trajectory& t, const Segment& segment, const SharedState& state,
                                   std::span<const ChainVariant> variants, int threads,
                                   std::size_t window_nodes) {
  const std::size_t nodes = segment.last_node - segment.first_node,
                    windows = chunk_count(nodes, window_nodes);
  std::vector<VariantSolver> solvers;
  solvers.reserve(variants.size());
  for (const ChainVariant& variant : variants) solvers.emplace_back(variant, t, windows);
  const auto factor = [&](std::size_t index) {
    const std::size_t first = segment.first_node + index * window_nodes,
                      last = std::min(first + window_nodes, segment.last_node);
    for (VariantSolver& solver : solvers) solver.begin(index, first, last, last < segment.last_node);
    // Includes the observations between its last state and the next one.
    for_each_row(t, stretch_of(t, segment, first, last + 1), state, [&](const ObservationRow& row) {
      for (VariantSolver& solver : solvers) solver.add(row);
    });
    for_each_parallel(solvers.size(), threads, [&](std::size_t i) { solvers[i].eliminate(); });
  };
  for (std::size_t index = 0; index + 1 < windows; ++index) {
    factor(index);
    for (VariantSolver& solver : solvers) solver.pass_on();
  }
  for (std::size_t index = windows; index-- > 0;) {
    factor(index);
    for_each_parallel(solvers.size(), threads, [&](std::size_t i) {
      if (solvers[i].is_determined()) solvers[i].substitute();
    });
    for (const VariantSolver& solver : solvers)
      if (solver.is_determined()) solver.visit();
  }
  std::vector<bool> determined;
  for (const VariantSolver& solver : solvers) determined.push_back(solver.is_determined());
  return determined;
}

}  // namespace octant
