// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/settle.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "models/support/parallel.h"
#include "models/trajectory/chain_solver.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/planar.h"

namespace octant {
namespace {

/// Smallest relative pivot of a node's block: whether its state is determined at all.
template <class Block>
bool is_singular(const Block& A) {
  const Eigen::LDLT<Block> ldlt(A);
  const auto d = ldlt.vectorD();
  return d.minCoeff() <= 1e-10 * d.maxCoeff();
}

template <int N>
void add_row(const ObservationRow& row, double w, std::size_t k, FixedChainSystem<N>& system) {
  const Eigen::Matrix<double, N, 1> a = row.by_node.template head<N>().transpose();
  system.D[k].noalias() += (w * a).lazyProduct(a.transpose());
  system.g[k].noalias() += (w * row.residual) * a;
  if (!row.has_next) return;
  const Eigen::Matrix<double, N, 1> b = row.by_next.template head<N>().transpose();
  system.D[k + 1].noalias() += (w * b).lazyProduct(b.transpose());
  system.g[k + 1].noalias() += (w * row.residual) * b;
  system.U[k].noalias() += (w * a).lazyProduct(b.transpose());
}

/// Any segment: its states are the nodes themselves.
template <int N>
class NodeChain {
 public:
  static constexpr int kSize = N;
  using Vector = Eigen::Matrix<double, N, 1>;

  NodeChain(Trajectory& t, const Segment& segment)
      : t_(t),
        segment_(segment),
        kept_(t.nodes.begin() + static_cast<std::ptrdiff_t>(segment.first_node),
              t.nodes.begin() + static_cast<std::ptrdiff_t>(segment.last_node), scratch()) {}

  void build(const SharedState& state, const RobustLoss& loss, FixedChainSystem<N>& system, int /*threads*/) {
    system.clear(kept_.size());
    for_each_row(t_, segment_, state, [&](const ObservationRow& row) {
      double rho = row.residual * row.residual, w = 1.0;
      if (is_robust(row.kind)) loss.evaluate(row.residual, rho, w);
      system.cost += 0.5 * rho;
      add_row(row, w, row.node - segment_.first_node, system);
    });
  }
  void move(const std::pmr::vector<Vector>& step) {
    const int dof = pose_dof(t_.motion);
    for (std::size_t k = 0; k < step.size(); ++k) {
      Node& node = t_.nodes[segment_.first_node + k];
      node.T_map_vehicle = retract(node.T_map_vehicle, step[k].head(dof), t_.motion);
      if (t_.has_cycle_offset) node.cycle_offset_s += step[k][dof] / t_.nominal_speed_mps;
      if (t_.motion_prior) node.velocity += step[k].template tail<3>();
    }
  }
  void keep() { std::copy(begin(), begin() + static_cast<std::ptrdiff_t>(kept_.size()), kept_.begin()); }
  void restore() { std::copy(kept_.begin(), kept_.end(), begin()); }
  void finish() {}

 private:
  [[nodiscard]] std::vector<Node>::iterator begin() {
    return t_.nodes.begin() + static_cast<std::ptrdiff_t>(segment_.first_node);
  }
  Trajectory& t_;
  const Segment& segment_;
  std::pmr::vector<Node> kept_;
};

/// Normal equations of the arrivals between two planar states, each symmetric block as xx, xy, xh, yy, yh,
/// hh.
struct IntervalSums {
  double D[6] = {}, U[6] = {}, D_next[6] = {}, g[3] = {}, g_next[3] = {};

  void add(const PlanarArrival& row, double w, double alpha) {
    const double x = row.by_x(), y = row.by_y(), h = row.by_heading;
    const double wx = w * x, wy = w * y, squares[6] = {wx * x, wx * y, wx * h, wy * y, wy * h, w * h * h};
    const double before = 1.0 - alpha, bb = before * before, ba = before * alpha, aa = alpha * alpha;
    for (int i = 0; i < 6; ++i) {
      D[i] += bb * squares[i];
      U[i] += ba * squares[i];
      D_next[i] += aa * squares[i];
    }
    const double r = row.residual, gradient[3] = {wx * r, wy * r, w * h * r};
    for (int i = 0; i < 3; ++i) {
      g[i] += before * gradient[i];
      g_next[i] += alpha * gradient[i];
    }
  }
  static void put(const double (&from)[6], Eigen::Matrix3d& to) {
    to(0, 0) += from[0];
    to(0, 1) += from[1];
    to(1, 0) += from[1];
    to(0, 2) += from[2];
    to(2, 0) += from[2];
    to(1, 1) += from[3];
    to(1, 2) += from[4];
    to(2, 1) += from[4];
    to(2, 2) += from[5];
  }
  void add_to(Eigen::Matrix3d& to_D, Eigen::Vector3d& to_g, Eigen::Matrix3d& to_U, Eigen::Matrix3d& to_next,
              Eigen::Vector3d& to_g_next) const {
    put(D, to_D);
    put(U, to_U);
    put(D_next, to_next);
    for (int i = 0; i < 3; ++i) {
      to_g[i] += g[i];
      to_g_next[i] += g_next[i];
    }
  }
};

/// A segment in the plane with plain arrivals, and odometry between its states or none.
class PlanarChain {
 public:
  static constexpr int kSize = 3;
  using Vector = Eigen::Vector3d;

  static bool takes(const Trajectory& t, const Segment& s, const SharedState& state) {
    return t.block_size() == kSize && has_planar_arrivals(t, s, state);
  }

  PlanarChain(Trajectory& t, const Segment& segment)
      : t_(t),
        segment_(segment),
        has_others_(segment.first_bearing < segment.last_bearing || segment.first_pose < segment.last_pose) {
    now_.reserve(segment.last_node - segment.first_node);
    for (std::size_t k = segment.first_node; k < segment.last_node; ++k)
      now_.emplace_back(t.nodes[k].T_map_vehicle);
    kept_ = now_;
  }

  /// Stretches of it side by side; sums do not depend on the number of threads.
  void build(const SharedState& state, const RobustLoss& loss, FixedChainSystem<3>& system, int threads) {
    const std::size_t count = now_.size(), stretches = chunk_count(count, kNodesAtOnce);
    system.clear(count);
    beyond_.assign(stretches, Beyond{});
    for_each_chunk(count, kNodesAtOnce, threads, [&](std::size_t chunk, std::size_t first, std::size_t last) {
      build_stretch(state, loss, first, last, system, beyond_[chunk]);
    });
    for (std::size_t chunk = 0; chunk < stretches; ++chunk) {
      const std::size_t next = (chunk + 1) * kNodesAtOnce;
      system.cost += beyond_[chunk].cost;
      if (next >= count) break;
      system.D[next] += beyond_[chunk].D;
      system.g[next] += beyond_[chunk].g;
    }
    if (has_others_) add_others(state, loss, system);
  }
  void move(const std::pmr::vector<Vector>& step) {
    for (std::size_t k = 0; k < step.size(); ++k) now_[k] = now_[k].moved(step[k][0], step[k][1], step[k][2]);
    moved_ = true;
  }
  void keep() { kept_ = now_; }
  void restore() { now_ = kept_; }
  void finish() {
    if (moved_) write();
  }

 private:
  static constexpr std::size_t kNodesAtOnce = 4096;
  /// What a stretch adds to the state behind it, and its cost.
  struct Beyond {
    Eigen::Matrix3d D = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    double cost = 0.0;
  };

  void write() {
    for (std::size_t k = 0; k < now_.size(); ++k)
      t_.nodes[segment_.first_node + k].T_map_vehicle = now_[k].pose();
  }

  template <class Observation>
  std::size_t first_at(const std::vector<Observation>& list, std::size_t first, std::size_t last,
                       std::size_t node) const {
    const auto begin = list.begin() + static_cast<std::ptrdiff_t>(first),
               end = list.begin() + static_cast<std::ptrdiff_t>(last);
    return static_cast<std::size_t>(
        std::partition_point(begin, end, [node](const Observation& o) { return o.node < node; }) -
        list.begin());
  }

  void build_stretch(const SharedState& state, const RobustLoss& loss, std::size_t first, std::size_t last,
                     FixedChainSystem<3>& system, Beyond& beyond) const {
    const std::size_t base = segment_.first_node;
    PlanarWhitening whitening(state.speed_offset(t_.run));
    std::size_t a = first_at(t_.arrivals, segment_.first_arrival, segment_.last_arrival, base + first),
                o = first_at(t_.odometry, segment_.first_odometry, segment_.last_odometry, base + first);
    const bool plain = is_plain(loss);
    double cost = 0.0;
    for (std::size_t k = first; k < last; ++k) {
      const bool at_end = k + 1 == now_.size();
      const PlanarInterval interval(now_[k], now_[at_end ? k : k + 1]);
      IntervalSums sums;
      for (; a < segment_.last_arrival && t_.arrivals[a].node == base + k; ++a) {
        const ArrivalObservation& heard = t_.arrivals[a];
        if (heard.rejection != Rejection::kUsed) continue;
        whitening.take(heard);
        const PlanarArrival row(heard, interval.at(heard.alpha), state, whitening);
        double rho = row.residual * row.residual, w = 1.0;
        if (!plain) loss.evaluate(row.residual, rho, w);
        cost += 0.5 * rho;
        sums.add(row, w, heard.alpha);
      }
      Eigen::Matrix3d& D_next = k + 1 == last ? beyond.D : system.D[k + 1];
      Eigen::Vector3d& g_next = k + 1 == last ? beyond.g : system.g[k + 1];
      sums.add_to(system.D[k], system.g[k], system.U[k], D_next, g_next);
      for (; o < segment_.last_odometry && t_.odometry[o].node == base + k; ++o) {
        const PlanarStep step(t_.odometry[o], interval);
        cost += step.cost();
        step.add_to(system.D[k], system.g[k], system.U[k], D_next, g_next);
      }
    }
    beyond.cost = cost;
  }

  /// Bearings and measured poses, of which there are few.
  void add_others(const SharedState& state, const RobustLoss& loss, FixedChainSystem<3>& system) {
    write();
    Segment others = segment_;
    others.first_arrival = others.last_arrival;
    others.first_odometry = others.last_odometry;
    for_each_row(t_, others, state, [&](const ObservationRow& row) {
      double rho = row.residual * row.residual, w = 1.0;
      if (is_robust(row.kind)) loss.evaluate(row.residual, rho, w);
      system.cost += 0.5 * rho;
      add_row(row, w, row.node - segment_.first_node, system);
    });
  }

  Trajectory& t_;
  const Segment& segment_;
  bool has_others_, moved_ = false;
  std::pmr::vector<PlanarNode> now_{scratch()}, kept_{scratch()};
  std::pmr::vector<Beyond> beyond_{scratch()};
};

/// A state that is held makes no step and passes none on.
template <int N>
void hold_ends(const SettleOptions& options, FixedChainSystem<N>& system) {
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

/// Whether a step is the last. One of b metres or radians leaves residuals off by b / 2 of what it changed
/// them, and derivatives by b, where beacons are a metre away or more. The next would gain the squares of
/// these.
template <class Vector>
bool is_last(const std::pmr::vector<Vector>& step, double gain, double cost, const RobustLoss& loss,
             const SettleOptions& options) {
  if (gain < options.tolerance * (1.0 + cost)) return true;
  if (options.left_behind <= 0.0 || !is_plain(loss)) return false;
  double b = 0.0;
  for (const Vector& v : step) b = std::max(b, v.template lpNorm<Eigen::Infinity>());
  const double rest = cost - gain;
  return b * b * (gain / 4 + rest) < options.left_behind * rest;
}

/// Levenberg-Marquardt: a point is built at once with its system, which the next step takes.
template <class Chain>
SettleResult settle_chain(Chain chain, const SharedState& state, const RobustLoss& loss,
                          const SettleOptions& options) {
  SettleResult result;
  FixedChainSystem<Chain::kSize> system, tried;
  FixedChainStep<Chain::kSize> work;
  double lambda = 1e-8;
  const auto build = [&](FixedChainSystem<Chain::kSize>& at) {
    chain.build(state, loss, at, options.threads);
    hold_ends(options, at);
  };
  build(system);
  for (; result.iterations < options.max_iterations; ++result.iterations) {
    bool improved = false;
    double gain = 0.0;
    for (int attempt = 0; attempt < 12 && !improved; ++attempt) {
      if (!work.solve(system, lambda)) {
        lambda = std::max(10 * lambda, 1e-4);
        continue;
      }
      gain = work.gain(system);
      if (!(gain > kSettledToRounding * (1.0 + system.cost))) break;
      chain.move(work.step());
      if (lambda < 1e-3 && is_last(work.step(), gain, system.cost, loss, options)) {
        system.cost -= gain;  // so near that the quadratic cost is as good as the cost
        gain = 0.0;
        break;
      }
      build(tried);
      improved = tried.cost <= system.cost * (1.0 + 1e-14);
      if (!improved) {
        chain.restore();
        lambda = std::max(10 * lambda, 1e-5);
      }
    }
    if (!improved) {
      // Nothing left to gain, or no step in any direction helps: at rest to rounding.
      result.converged = gain < 1e-6 * (1.0 + system.cost);
      break;
    }
    lambda = lambda < 1e-7 ? 1e-8 : 0.1 * lambda;
    chain.keep();
    std::swap(system, tried);
  }
  chain.finish();
  result.cost = system.cost;
  result.singular = system.D.size() == 1 && is_singular(system.D[0]);
  return result;
}

}  // namespace

SettleResult settle(Trajectory& t, const Segment& segment, const SharedState& state, const RobustLoss& loss,
                    const SettleOptions& options) {
  if (PlanarChain::takes(t, segment, state))
    return settle_chain(PlanarChain(t, segment), state, loss, options);
  switch (t.block_size()) {
    case 3: return settle_chain(NodeChain<3>(t, segment), state, loss, options);
    case 4: return settle_chain(NodeChain<4>(t, segment), state, loss, options);
    case 6: return settle_chain(NodeChain<6>(t, segment), state, loss, options);
    default: return settle_chain(NodeChain<7>(t, segment), state, loss, options);
  }
}

SettleResult settle(Trajectory& t, const Segment& segment, const SharedState& state, const RobustLoss& loss,
                    int max_iterations) {
  return settle(t, segment, state, loss, SettleOptions{.max_iterations = max_iterations});
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
