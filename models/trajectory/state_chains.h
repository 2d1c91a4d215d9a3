// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to solve_states(): the chains that it moves, and their normal equations.

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "models/support/parallel.h"
#include "models/trajectory/chain_solver.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/node_step.h"
#include "models/trajectory/planar.h"
#include "models/trajectory/solve_states.h"
#include "models/trajectory/spatial.h"
#include "models/trajectory/stretches.h"

namespace octant {

/// States that a thread takes at once.
inline constexpr std::size_t kNodesAtOnce = 1024;

/// What a stretch adds to the state behind it, and its cost.
template <int N>
struct BeyondStretch {
  Eigen::Matrix<double, N, N> D = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> g = Eigen::Matrix<double, N, 1>::Zero();
  double cost = 0.0;
};

/// Builds stretches of a chain side by side, build(beyond, first, last); sums do not depend on the number of
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

/// @param beyond  takes what belongs to the next state; null: the system does
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

  void build(const SharedState& state, const RobustLoss& loss, FixedChainSystem<N>& system, int threads) {
    const bool is_spatial = N == 6 && has_spatial_arrivals(t_, segment_, state);
    const auto stretch = [&](BeyondStretch<N>& beyond, std::size_t first, std::size_t last) {
      const std::size_t base = segment_.first_node;
      // Up to the observations between its last state and the one behind it.
      Segment part =
          last - first == kept_.size() ? segment_ : stretch_of(t_, segment_, base + first, base + last + 1);
      if constexpr (N == 6) {
        if (is_spatial) {
          add_spatial(part, first, last, state, loss, system, beyond);
          part.first_arrival = part.last_arrival;
          part.first_odometry = part.last_odometry;
        }
      }
      for_each_row(t_, part, state, [&](const ObservationRow& row) {
        double rho = row.residual * row.residual, w = 1.0;
        if (is_robust(row.kind)) loss.evaluate(row.residual, rho, w);
        beyond.cost += 0.5 * rho;
        const std::size_t k = row.node - base;
        add_row(row, w, k, system, k + 1 == last ? &beyond : nullptr);
      });
    };
    build_stretches(kept_.size(), threads, system, stretch);
  }
  void move(const std::pmr::vector<Vector>& step, int threads) {
    for_each_chunk(step.size(), kNodesAtOnce, threads, [&](std::size_t, std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) step_node(t_, step[k], t_.nodes[segment_.first_node + k]);
    });
  }
  void keep() { std::copy(begin(), begin() + static_cast<std::ptrdiff_t>(kept_.size()), kept_.begin()); }
  void restore() { std::copy(kept_.begin(), kept_.end(), begin()); }
  void finish() {}

 private:
  /// Plain arrivals and odometry of a stretch.
  void add_spatial(const Segment& part, std::size_t first, std::size_t last, const SharedState& state,
                   const RobustLoss& loss, FixedChainSystem<N>& system, BeyondStretch<N>& beyond) const {
    ArrivalWhitening whitening(state.speed_offset(t_.run));
    std::size_t a = part.first_arrival, o = part.first_odometry;
    const bool plain = is_plain(loss);
    double cost = 0.0;
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t node = segment_.first_node + k;
      const bool at_end = k + 1 == kept_.size(), is_last = k + 1 == last;
      const SpatialInterval interval(t_.nodes[node].T_map_vehicle,
                                     t_.nodes[at_end ? node : node + 1].T_map_vehicle);
      Eigen::Matrix<double, N, N>&D = system.D[k], &U = system.U[k],
                               &D_next = is_last ? beyond.D : system.D[k + 1];
      Vector &g = system.g[k], &g_next = is_last ? beyond.g : system.g[k + 1];
      for (; a < part.last_arrival && t_.arrivals[a].node == node; ++a) {
        const ArrivalObservation& heard = t_.arrivals[a];
        if (heard.rejection != Rejection::kUsed) continue;
        whitening.set(heard);
        const SpatialInstant at(interval, heard.alpha);
        const SpatialArrival row(heard, interval, at, state, whitening);
        double rho = row.residual * row.residual, w = 1.0;
        if (!plain) loss.evaluate(row.residual, rho, w);
        cost += 0.5 * rho;
        const Vector by_node = w * row.by_node;
        g += row.residual * by_node;
        add_product(by_node, row.by_node, D);
        if (heard.alpha == 0.0) continue;
        const Vector by_next = w * row.by_next;
        g_next += row.residual * by_next;
        add_product(by_node, row.by_next, U);
        add_product(by_next, row.by_next, D_next);
      }
      for (; o < part.last_odometry && t_.odometry[o].node == node; ++o) {
        const SpatialStep step(t_.odometry[o], interval);
        cost += step.cost();
        step.add_to(D, g, U, D_next, g_next);
      }
    }
    beyond.cost += cost;
  }
  static void add_product(const Vector& a, const Vector& b, Eigen::Matrix<double, N, N>& to) {
    for (int j = 0; j < N; ++j) to.col(j) += b[j] * a;
  }

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

  void build(const SharedState& state, const RobustLoss& loss, FixedChainSystem<3>& system, int threads) {
    build_stretches(now_.size(), threads, system,
                    [&](BeyondStretch<3>& beyond, std::size_t first, std::size_t last) {
                      build_stretch(state, loss, first, last, system, beyond);
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
                     FixedChainSystem<3>& system, BeyondStretch<3>& beyond) const {
    const std::size_t base = segment_.first_node;
    ArrivalWhitening whitening(state.speed_offset(t_.run));
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
        whitening.set(heard);
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
};

}  // namespace octant
