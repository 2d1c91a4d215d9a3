// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "models/trajectory/linearise.h"
#include "models/trajectory/trajectory.h"

namespace octant {
namespace {

/// What the steps of one settling share, so that each takes no memory of its own.
struct ChainStep {
  std::pmr::vector<Eigen::LLT<NodeBlock>> factor{scratch()};
  std::pmr::vector<NodeVector> step{scratch()};
};

/// Solves the damped block-tridiagonal system (D + lambda diag D) and U for the step -A^-1 g; false if not
/// positive definite.
bool solve_chain(const ChainSystem& system, double lambda, ChainStep& out) {
  const std::size_t count = system.D.size();
  auto& [factor, step] = out;
  factor.resize(count);
  step.resize(count);
  NodeVector rhs = -system.g[0];
  NodeBlock A = system.D[0];
  for (std::size_t k = 0;; ++k) {
    // The floor keeps a direction that nothing observes (the heading of a single antenna) where it is.
    A.diagonal().array() +=
        lambda * system.D[k].diagonal().array() + 1e-9 * (1.0 + system.D[k].diagonal().maxCoeff());
    factor[k].compute(A);
    if (factor[k].info() != Eigen::Success) return false;
    step[k] = rhs;
    if (k + 1 == count) break;
    const NodeBlock W = factor[k].solve(system.U[k]);  // A^-1 U
    rhs = -system.g[k + 1] - W.transpose() * step[k];
    A = system.D[k + 1] - system.U[k].transpose() * W;
  }
  step[count - 1] = factor[count - 1].solve(step[count - 1]);
  for (std::size_t k = count - 1; k-- > 0;) step[k] = factor[k].solve(step[k] - system.U[k] * step[k + 1]);
  return true;
}

void move_nodes(Trajectory& t, const Segment& segment, const std::pmr::vector<NodeVector>& step) {
  const int dof = pose_dof(t.motion);
  for (std::size_t k = 0; k < step.size(); ++k) {
    Node& node = t.nodes[segment.first_node + k];
    node.T_map_vehicle = retract(node.T_map_vehicle, step[k].head(dof), t.motion);
    if (t.has_cycle_offset) node.cycle_offset_s += step[k][dof] / t.nominal_speed_mps;
    if (t.motion_prior) node.velocity += step[k].segment<3>(dof);
  }
}

/// Smallest relative pivot of a node's block: whether its state is determined at all.
bool is_singular(const NodeBlock& A) {
  Eigen::LDLT<NodeBlock> ldlt(A);
  const auto d = ldlt.vectorD();
  return d.minCoeff() <= 1e-10 * d.maxCoeff();
}

}  // namespace

SettleResult settle(Trajectory& t, const Segment& segment, const SharedState& state, const RobustLoss& loss,
                    int max_iterations) {
  SettleResult result;
  ChainSystem system;
  ChainStep work;
  const auto& step = work.step;
  double lambda = 1e-8;
  build_chain_system(t, segment, state, loss, system);
  std::pmr::vector<Node> before(t.nodes.begin() + static_cast<std::ptrdiff_t>(segment.first_node),
                                t.nodes.begin() + static_cast<std::ptrdiff_t>(segment.last_node), scratch());
  const auto restore = [&] {
    std::copy(before.begin(), before.end(),
              t.nodes.begin() + static_cast<std::ptrdiff_t>(segment.first_node));
  };
  for (; result.iterations < max_iterations; ++result.iterations) {
    bool improved = false;
    double gain = 0.0;
    for (int attempt = 0; attempt < 12 && !improved; ++attempt) {
      if (!solve_chain(system, lambda, work)) {
        lambda = std::max(10 * lambda, 1e-4);
        continue;
      }
      gain = 0.0;  // half the Newton decrement: what a quadratic cost would lose
      for (std::size_t k = 0; k < step.size(); ++k) gain -= 0.5 * system.g[k].dot(step[k]);
      if (!(gain > 1e-13 * (1.0 + system.cost))) break;
      move_nodes(t, segment, step);
      improved = chain_cost(t, segment, state, loss) <= system.cost * (1.0 + 1e-14);
      if (!improved) {
        restore();
        lambda = std::max(10 * lambda, 1e-5);
      }
    }
    if (!improved) {
      // Nothing left to gain, or no step in any direction helps: at rest to rounding.
      result.converged = gain < 1e-6 * (1.0 + system.cost);
      break;
    }
    lambda = lambda < 1e-7 ? 1e-8 : 0.1 * lambda;
    std::copy(t.nodes.begin() + static_cast<std::ptrdiff_t>(segment.first_node),
              t.nodes.begin() + static_cast<std::ptrdiff_t>(segment.last_node), before.begin());
    build_chain_system(t, segment, state, loss, system);
  }
  result.cost = system.cost;
  for (const NodeBlock& D : system.D)
    result.singular = result.singular || (system.D.size() == 1 && is_singular(D));
  return result;
}

StateCovariance node_covariance(const Trajectory& t, const Segment& segment, std::size_t node,
                                const SharedState& state) {
  ChainSystem system;
  build_chain_system(t, segment, state, RobustLoss{}, system);
  const std::size_t at = node - segment.first_node;
  NodeBlock A = system.D[at];
  const auto eliminate = [](const NodeBlock& D, const NodeBlock& U) -> NodeBlock {
    return U.transpose() * Eigen::LDLT<NodeBlock>(D).solve(U);
  };
  NodeBlock left = system.D[0];
  for (std::size_t k = 0; k < at; ++k) {
    const NodeBlock taken = eliminate(left, system.U[k]);
    if (k + 1 == at) A -= taken;
    left = system.D[k + 1] - taken;
  }
  const std::size_t last = system.D.size() - 1;
  NodeBlock right = system.D[last];
  for (std::size_t k = last; k > at; --k) {
    const NodeBlock taken = eliminate(right, system.U[k - 1].transpose());
    if (k - 1 == at) A -= taken;
    right = system.D[k - 1] - taken;
  }
  if (is_singular(A)) return {};
  const Eigen::LDLT<NodeBlock> ldlt(A);
  if (ldlt.vectorD().minCoeff() <= 0) return {};
  return ldlt.solve(NodeBlock::Identity(A.rows(), A.cols()));
}

}  // namespace octant
