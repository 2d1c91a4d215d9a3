// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to solve_states(): chains of states and their normal equations.

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "models/support/parallel.h"
#include "models/trajectory/chain_solver.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/planar.h"
#include "models/trajectory/spatial.h"
#include "models/trajectory/stretches.h"

namespace octant {

/// Number of states in the chunk of a thread.
inline constexpr std::size_t kNodesAtOnce = 1024;

/// Contribution of a chunk to the state behind it, and its cost.
template <int N>
struct BeyondStretch {
  Eigen::Matrix<double, N, N> D = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> g = Eigen::Matrix<double, N, 1>::Zero();
  double cost = 0.0;
};

/// Builds the chunks of a chain in parallel, build(beyond, first, last). Sums do not depend on the number of
/// threads.
template <int N, class Build>
void build_stretches(std::size_t count, int threads, FixedChainSystem<N>& system, Build&& build) {
  system.resize(count);
  std::pmr::vector<BeyondStretch<N>> beyond(chunk_count(count, kNodesAtOnce), scratch());
  for_each_chunk(count, kNodesAtOnce, threads, [&](std::size_t chunk, std::size_t first, std::size_t last) {
    system.clear(first, last);
    build(beyond[chunk], first, last);
  });
  for (std::size_t chunk = 0; chunk < beyond.size(); ++chunk) {
    const std::size_t next = (chunk + 1) * kNodesAtOnce;
    system.cost += beyond[chunk].cost;
    if (next >= count) break;
    system.D[next] += beyond[chunk].D;
    system.g[next] += beyond[chunk].g;
  }
}

/// @param beyond  receives the terms of the next state; null: they go into the system
template <int N>
void add_row(const ObservationRow& row, double w, std::size_t k, FixedChainSystem<N>& system,
             BeyondStretch<N>* beyond = nullptr) {
  const Eigen::Matrix<double, N, 1> a = row.by_node.template head<N>().transpose();
  system.D[k].noalias() += (w * a).lazyProduct(a.transpose());
  system.g[k].noalias() += (w * row.residual) * a;
  if (!row.has_next) return;
  const Eigen::Matrix<double, N, 1> b = row.by_next.template head<N>().transpose();
  (beyond ? beyond->D : system.D[k + 1]).noalias() += (w * b).lazyProduct(b.transpose());
  (beyond ? beyond->g : system.g[k + 1]).noalias() += (w * row.residual) * b;
  system.U[k].noalias() += (w * a).lazyProduct(b.transpose());
}

/// References to the normal equations of two neighbouring states.
template <int N>
struct IntervalBlocks {
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;
  Block &D, &U, &D_next;
  Vector &g, &g_next;
};

/// Adds arrivals between two states in space.
struct SpatialBlocks : IntervalBlocks<6> {
  explicit SpatialBlocks(const IntervalBlocks<6>& to) : IntervalBlocks<6>(to) {}

  void add(const ArrivalObservation& heard, const SpatialInterval& interval, const SharedState& state,
           const ArrivalWhitening& whitening, const RobustLoss& loss, double& cost) {
    const SpatialArrival row(heard, interval, SpatialInstant(interval, heard.alpha), state, whitening);
    const double w = loss.weigh(row.residual, cost);
    const Vector by_node = w * row.by_node;
    g += row.residual * by_node;
    add_product(by_node, row.by_node, D);
    if (heard.alpha == 0.0) return;
    const Vector by_next = w * row.by_next;
    g_next += row.residual * by_next;
    add_product(by_node, row.by_next, U);
    add_product(by_next, row.by_next, D_next);
  }
  void finish() {}

 private:
  static void add_product(const Vector& a, const Vector& b, Block& to) {
    for (int j = 0; j < 6; ++j) to.col(j) += b[j] * a;
  }
};

/// Adds arrivals between two planar states. Each symmetric block is accumulated as xx, xy, xh, yy, yh, hh.
class PlanarBlocks {
 public:
  explicit PlanarBlocks(const IntervalBlocks<3>& to) : to_(to) {}

  void add(const ArrivalObservation& heard, const PlanarInterval& interval, const SharedState& state,
           const ArrivalWhitening& whitening, const RobustLoss& loss, double& cost) {
    const PlanarArrival row(heard, interval.at(heard.alpha), state, whitening);
    const double w = loss.weigh(row.residual, cost), alpha = heard.alpha;
    const double x = row.by_x(), y = row.by_y(), h = row.by_heading;
    const double wx = w * x, wy = w * y, squares[6] = {wx * x, wx * y, wx * h, wy * y, wy * h, w * h * h};
    const double before = 1.0 - alpha, bb = before * before, ba = before * alpha, aa = alpha * alpha;
    for (int i = 0; i < 6; ++i) {
      D_[i] += bb * squares[i];
      U_[i] += ba * squares[i];
      D_next_[i] += aa * squares[i];
    }
    const double r = row.residual, gradient[3] = {wx * r, wy * r, w * h * r};
    for (int i = 0; i < 3; ++i) {
      g_[i] += before * gradient[i];
      g_next_[i] += alpha * gradient[i];
    }
  }
  void finish() {
    add_symmetric(D_, to_.D);
    add_symmetric(U_, to_.U);
    add_symmetric(D_next_, to_.D_next);
    for (int i = 0; i < 3; ++i) {
      to_.g[i] += g_[i];
      to_.g_next[i] += g_next_[i];
    }
  }

 private:
  static void add_symmetric(const double (&from)[6], Eigen::Matrix3d& to) {
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
  IntervalBlocks<3> to_;
  double D_[6] = {}, U_[6] = {}, D_next_[6] = {}, g_[3] = {}, g_next_[3] = {};
};

/// Adds the plain arrivals and the odometry of states [first, last) of a segment, interval by interval.
/// @param interval_at  (k): interval from the segment's state k to the next one, or to itself for the last
/// state
template <class Blocks, class Step, int N, class IntervalAt>
void add_intervals(const Trajectory& t, const Segment& segment, std::size_t first, std::size_t last,
                   const SharedState& state, const RobustLoss& loss, IntervalAt&& interval_at,
                   FixedChainSystem<N>& system, BeyondStretch<N>& beyond) {
  const std::size_t base = segment.first_node;
  ArrivalWhitening whitening(state.speed_offset(t.run));
  std::size_t a = first_of_node(t.arrivals, base + first, segment.first_arrival, segment.last_arrival),
              o = first_of_node(t.odometry, base + first, segment.first_odometry, segment.last_odometry);
  double cost = 0.0;
  for (std::size_t k = first; k < last; ++k) {
    const auto interval = interval_at(k);
    const bool is_last = k + 1 == last;
    const IntervalBlocks<N> to{system.D[k], system.U[k], is_last ? beyond.D : system.D[k + 1], system.g[k],
                               is_last ? beyond.g : system.g[k + 1]};
    Blocks blocks(to);
    for (; a < segment.last_arrival && t.arrivals[a].node == base + k; ++a) {
      if (t.arrivals[a].rejection != Rejection::kUsed) continue;
      whitening.set(t.arrivals[a]);
      blocks.add(t.arrivals[a], interval, state, whitening, loss, cost);
    }
    blocks.finish();
    for (; o < segment.last_odometry && t.odometry[o].node == base + k; ++o) {
      const Step step(t.odometry[o], interval);
      cost += step.cost();
      step.add_to(to.D, to.g, to.U, to.D_next, to.g_next);
    }
  }
  beyond.cost += cost;
}

/// Chain of any segment, whose states are the nodes themselves.
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

  void build(const SharedState& state, const RobustLoss& loss, FixedChainSystem<N>& system, int threads) {
    const bool is_spatial = N == 6 && has_spatial_arrivals(t_, segment_, state);
    const auto stretch = [&](BeyondStretch<N>& beyond, std::size_t first, std::size_t last) {
      const std::size_t base = segment_.first_node;
      // Includes the observations between its last state and the next one.
      Segment part =
          last - first == kept_.size() ? segment_ : stretch_of(t_, segment_, base + first, base + last + 1);
      if constexpr (N == 6) {
        if (is_spatial) {
          add_intervals<SpatialBlocks, SpatialStep>(
              t_, segment_, first, last, state, loss,
              [this](std::size_t k) {
                const Node* const node = &t_.nodes[segment_.first_node + k];
                return SpatialInterval(node[0].T_map_vehicle,
                                       node[k + 1 < kept_.size() ? 1 : 0].T_map_vehicle);
              },
              system, beyond);
          part.first_arrival = part.last_arrival;
          part.first_odometry = part.last_odometry;
        }
      }
      for_each_row(t_, part, state, [&](const ObservationRow& row) {
        const double w = weigh(row, loss, beyond.cost);
        const std::size_t k = row.node - base;
        add_row(row, w, k, system, k + 1 == last ? &beyond : nullptr);
      });
    };
    build_stretches(kept_.size(), threads, system, stretch);
  }
  void move(const std::pmr::vector<Vector>& step, int threads) {
    for_each_in_chunks(step.size(), kNodesAtOnce, threads,
                       [&](std::size_t k) { step_node(t_, step[k], t_.nodes[segment_.first_node + k]); });
  }
  void keep() { std::copy(begin(), begin() + static_cast<std::ptrdiff_t>(kept_.size()), kept_.begin()); }
  void restore() { std::ranges::copy(kept_, begin()); }
  void finish() {}

 private:
  [[nodiscard]] std::vector<Node>::iterator begin() {
    return t_.nodes.begin() + static_cast<std::ptrdiff_t>(segment_.first_node);
  }
  Trajectory& t_;
  const Segment& segment_;
  std::pmr::vector<Node> kept_;
};

/// Chain of a planar segment with plain arrivals, with or without odometry.
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

  void build(const SharedState& state, const RobustLoss& loss, FixedChainSystem<3>& system, int threads) {
    build_stretches(now_.size(), threads, system,
                    [&](BeyondStretch<3>& beyond, std::size_t first, std::size_t last) {
                      add_intervals<PlanarBlocks, PlanarStep>(
                          t_, segment_, first, last, state, loss,
                          [this](std::size_t k) {
                            return PlanarInterval(now_[k], now_[k + 1 < now_.size() ? k + 1 : k]);
                          },
                          system, beyond);
                    });
    if (has_others_) add_others(state, loss, system);
  }
  void move(const std::pmr::vector<Vector>& step, int) {
    for (std::size_t k = 0; k < step.size(); ++k) now_[k] = now_[k].moved(step[k][0], step[k][1], step[k][2]);
    moved_ = true;
  }
  void keep() { kept_ = now_; }
  void restore() { now_ = kept_; }
  void finish() {
    if (moved_) write();
  }

 private:
  void write() {
    for (std::size_t k = 0; k < now_.size(); ++k)
      t_.nodes[segment_.first_node + k].T_map_vehicle = now_[k].pose();
  }

  /// Adds bearings and measured poses, which are few.
  void add_others(const SharedState& state, const RobustLoss& loss, FixedChainSystem<3>& system) {
    write();
    Segment others = segment_;
    others.first_arrival = others.last_arrival;
    others.first_odometry = others.last_odometry;
    for_each_row(t_, others, state, [&](const ObservationRow& row) {
      const double w = weigh(row, loss, system.cost);
      add_row(row, w, row.node - segment_.first_node, system);
    });
  }

  Trajectory& t_;
  const Segment& segment_;
  bool has_others_, moved_ = false;
  std::pmr::vector<PlanarNode> now_{scratch()}, kept_{scratch()};
};

}  // namespace octant
