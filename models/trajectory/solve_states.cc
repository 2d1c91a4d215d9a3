// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/solve_states.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "models/support/observed.h"
#include "models/trajectory/chain_solver.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/state_chains.h"

namespace octant {
namespace {

/// A fixed state has a zero step and is decoupled from its neighbours.
template <int N>
void hold_ends(const StateSolveOptions& options, FixedChainSystem<N>& system) {
  const std::size_t last = system.D.size() - 1;
  const auto hold = [&](std::size_t k) {
    system.D[k].setIdentity();
    system.g[k].setZero();
    if (k > 0) system.U[k - 1].setZero();
    if (k < last) system.U[k].setZero();
  };
  if (options.hold_first) hold(0);
  if (options.hold_last) hold(last);
}

/// Returns true if a step is the last one. With beacons at least one metre away, a step of b metres or
/// radians leaves a linearisation error of b / 2 of the change in the residuals, and of b in the derivatives.
/// The gain of the next step is quadratic in both.
template <class Vector>
bool is_last(const std::pmr::vector<Vector>& step, double gain, double cost, const RobustLoss& loss,
             const StateSolveOptions& options) {
  if (gain < options.tolerance * (1.0 + cost)) return true;
  if (options.left_behind <= 0.0 || !is_plain(loss)) return false;
  double b = 0.0;
  for (const Vector& v : step) b = std::max(b, v.template lpNorm<Eigen::Infinity>());
  const double rest = cost - gain;
  return b * b * (gain / 4 + rest) < options.left_behind * rest;
}

/// Levenberg-Marquardt iteration. Building a state's cost also builds the system of the next step. Only one
/// system exists, because that of a long drive needs most of the memory, so a rejected step is followed by
/// building it again.
template <class Chain>
StateSolveResult solve_chain(Chain chain, const SharedState& state, const RobustLoss& loss,
                             const StateSolveOptions& options) {
  StateSolveResult result;
  FixedChainSystem<Chain::kSize> system;
  typename FixedChainSystem<Chain::kSize>::Block alone;  // copy of the block of a single state
  FixedChainStep<Chain::kSize> work;
  double lambda = 1e-8;
  const auto build = [&] {
    chain.build(state, loss, system, options.threads);
    hold_ends(options, system);
    if (system.D.size() == 1) alone = system.D[0];
  };
  build();
  for (; result.iterations < options.max_iterations; ++result.iterations) {
    bool improved = false;
    double gain = 0.0;
    for (int attempt = 0; attempt < 12 && !improved; ++attempt) {
      if (!work.solve(system, lambda, options.threads)) {
        lambda = std::max(10 * lambda, 1e-4);
        build();
        continue;
      }
      gain = work.gain(system);
      if (!(gain > kConvergedToRounding * (1.0 + system.cost))) break;
      chain.move(work.step(), options.threads);
      if (lambda < 1e-3 && is_last(work.step(), gain, system.cost, loss, options)) {
        system.cost -= gain;  // close enough for the quadratic model to be exact
        gain = 0.0;
        break;
      }
      const double before = system.cost;
      build();
      improved = system.cost <= before * (1.0 + 1e-14);
      if (!improved) {
        chain.restore();
        build();
        lambda = std::max(10 * lambda, 1e-5);
      }
    }
    if (!improved) {
      // Converged to rounding: no gain left, or no direction improves the cost.
      result.converged = gain < 1e-6 * (1.0 + system.cost);
      break;
    }
    lambda = lambda < 1e-7 ? 1e-8 : 0.1 * lambda;
    chain.keep();
  }
  chain.finish();
  result.cost = system.cost;
  result.singular = system.D.size() == 1 && !ObservedState(alone).all();
  return result;
}

}  // namespace

StateSolveResult solve_states(Trajectory& t, const Segment& segment, const SharedState& state,
                              const RobustLoss& loss, const StateSolveOptions& options) {
  if (PlanarChain::takes(t, segment, state))
    return solve_chain(PlanarChain(t, segment), state, loss, options);
  switch (t.block_size()) {
    case 3: return solve_chain(NodeChain<3>(t, segment), state, loss, options);
    case 4: return solve_chain(NodeChain<4>(t, segment), state, loss, options);
    case 6: return solve_chain(NodeChain<6>(t, segment), state, loss, options);
    default: return solve_chain(NodeChain<7>(t, segment), state, loss, options);
  }
}

StateSolveResult solve_states(Trajectory& t, const Segment& segment, const SharedState& state,
                              const RobustLoss& loss, int max_iterations) {
  return solve_states(t, segment, state, loss, StateSolveOptions{.max_iterations = max_iterations});
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
  const ObservedState<NodeBlock> observed(A);
  if (!observed.all()) return {};
  return observed.covariance();
}

}  // namespace octant
