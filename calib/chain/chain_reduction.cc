// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/chain/chain_reduction.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "calib/chain/chain_kernel.h"
#include "calib/chain/stretch_reducer.h"
#include "calib/lanes/stop_block.h"
#include "calib/sums/reduced_system.h"
#include "models/support/parallel.h"

namespace octant::calib {
namespace {

using chain::AlignedDoubles;
using chain::ReducedStretch;
using chain::Stretch;
using chain::StretchReducer;

constexpr std::size_t kNodesPerStretch = 512;
constexpr std::size_t kDoublesAtOnce =
    1U << 20U;  ///< numbers of the borders of segments that are kept at the same time

/// Joins the ends of segments, one after the other.
template <int N>
class Joiner {
 public:
  static constexpr std::size_t n = N;

  explicit Joiner(ReducedSystem& system)
      : system_(system),
        columns_(static_cast<std::size_t>(system.H.cols())),
        width_((columns_ + kBorderPad) / kBorderPad * kBorderPad) {}

  void add_stretch(const Stretch& stretch, const ReducedStretch& from) {
    const std::size_t m = from.columns.size(), gradient = m + (stretch.has_left ? n : 0);
    cost_ += from.cost + 0.5 * from.H.data()[gradient * from.width + gradient];
    for (std::size_t i = 0; i < m; ++i) {
      const double* row = from.H.data() + i * from.width;
      for (std::size_t j = 0; j <= i; ++j) system_.H(from.columns[i], from.columns[j]) += row[j];
      system_.gradient[from.columns[i]] += from.H.data()[gradient * from.width + i];
    }
    if (!stretch.has_left && !stretch.has_right) return;
    if (H_.data() == nullptr) {
      H_.assign_zero(width_ * width_);
      D_.assign_zero(2 * n * n);
      U_.assign_zero(n * n);
      G_.assign_zero(2 * n * width_);
    }
    if (stretch.has_left) join_left(from, gradient);
    double* const D = D_.data() + (stretch.has_left ? n * n : 0);
    double* const G = G_.data() + (stretch.has_left ? n * width_ : 0);
    if (stretch.has_right) {
      for (std::size_t i = 0; i < n; ++i) {
        const double* g = from.G.data() + i * from.width;
        for (std::size_t j = 0; j < n; ++j) {
          D[i * n + j] += from.D[i * n + j];
          if (stretch.has_left) U_.data()[j * n + i] = g[from.left() + j];
        }
        for (std::size_t j = 0; j < m; ++j) G[i * width_ + static_cast<std::size_t>(from.columns[j])] += g[j];
        G[i * width_ + columns_] += g[gradient];
      }
    }
    if (!stretch.has_left) return;
    eliminate({N, 1, width_, D_.data(), U_.data(), G_.data(), H_.data()}, 0.0, kUnobservedFloor);
    std::memcpy(D_.data(), D, n * n * sizeof(double));
    std::memcpy(G_.data(), G, n * width_ * sizeof(double));
    std::fill(D, D + n * n, 0.0);
    std::fill(G, G + n * width_, 0.0);
    std::fill(U_.data(), U_.data() + n * n, 0.0);
  }

  /// @return cost where the states have made the step that is left to them
  [[nodiscard]] double finish() {
    if (H_.data() == nullptr) return cost_;
    for (std::size_t i = 0; i < columns_; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      for (std::size_t j = 0; j <= i; ++j)
        system_.H(row, static_cast<Eigen::Index>(j)) += H_.data()[i * width_ + j];
      system_.gradient[row] += H_.data()[columns_ * width_ + i];
    }
    return cost_ + 0.5 * H_.data()[columns_ * width_ + columns_];
  }

 private:
  /// Contribution of a segment to the end before it.
  void join_left(const ReducedStretch& from, std::size_t gradient) {
    for (std::size_t i = 0; i < n; ++i) {
      const double* row = from.H.data() + (from.left() + i) * from.width;
      for (std::size_t j = 0; j < n; ++j)
        D_.data()[i * n + j] +=
            j <= i ? row[from.left() + j] : from.H.data()[(from.left() + j) * from.width + from.left() + i];
      double* G = G_.data() + i * width_;
      for (std::size_t j = 0; j < from.columns.size(); ++j)
        G[static_cast<std::size_t>(from.columns[j])] += row[j];
      G[columns_] += from.H.data()[gradient * from.width + from.left() + i];
    }
  }

  ReducedSystem& system_;
  std::size_t columns_, width_;
  double cost_ = 0.0;
  AlignedDoubles H_, D_, U_, G_;  ///< blocks of an end and the next one
};

std::vector<Stretch> stretches_of(std::size_t states) {
  if (states <= 2 * kNodesPerStretch) return {{false, false, 0, states}};
  std::vector<Stretch> out;
  for (std::size_t end = kNodesPerStretch, first = 0;; end += kNodesPerStretch) {
    const bool is_last = end + kNodesPerStretch / 2 > states;
    out.push_back({first > 0, !is_last, first, is_last ? states : end});
    if (is_last) return out;
    first = end + 1;
  }
}

template <int N>
double reduce_segment(const ChainPaths& chain, const Segment& segment, const SharedState& state,
                      const RobustLoss& loss, const std::vector<int>& place, int threads,
                      ReducedSystem& system) {
  const auto columns = static_cast<std::size_t>(system.H.cols());
  const std::vector<Stretch> stretches = stretches_of(segment.last_node - segment.first_node);
  const std::size_t at_once =
      std::clamp<std::size_t>(kDoublesAtOnce / std::max<std::size_t>(columns * columns, 1), 2, 32);
  std::vector<ReducedStretch> reduced(std::min(at_once, stretches.size()));
  Joiner<N> join(system);
  for (std::size_t first = 0; first < stretches.size(); first += at_once) {
    const std::size_t count = std::min(at_once, stretches.size() - first);
    for_each_parallel(count, threads, [&](std::size_t i) {
      StretchReducer<N>(chain, segment, state, loss, place, columns).reduce(stretches[first + i], reduced[i]);
    });
    for (std::size_t i = 0; i < count; ++i) join.add_stretch(stretches[first + i], reduced[i]);
  }
  return join.finish();
}

template <int N>
void reduce_open_segment(const ChainPaths& chain, const Segment& segment, const SharedState& state,
                         const RobustLoss& loss, const std::vector<int>& place, std::size_t columns,
                         OpenChain& out) {
  const Stretch stretch{out.has_left, out.has_right, out.has_left ? 1U : 0U,
                        segment.last_node - segment.first_node - (out.has_right ? 1U : 0U)};
  ReducedStretch from;
  StretchReducer<N>(chain, segment, state, loss, place, columns).reduce(stretch, from);
  // Position of each column of its border; the gradient's is the last.
  const std::size_t gradient = from.gradient(out.has_left ? N : 0);
  std::vector<Eigen::Index> at(from.columns.begin(), from.columns.end());
  const auto left = static_cast<Eigen::Index>(columns), right = left + (out.has_left ? N : 0),
             size = right + (out.has_right ? N : 0);
  for (Eigen::Index i = left; i < right; ++i) at.push_back(i);
  out.cost = from.cost + 0.5 * from.H.data()[gradient * from.width + gradient];
  out.gradient.setZero(size);
  out.H.setZero(size, size);
  for (std::size_t i = 0; i < at.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) out.H(at[i], at[j]) = from.H.data()[i * from.width + j];
    out.gradient[at[i]] = from.H.data()[gradient * from.width + i];
  }
  for (std::size_t i = 0; out.has_right && i < N; ++i) {
    const Eigen::Index row = right + static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < at.size(); ++j) out.H(row, at[j]) = from.G[i * from.width + j];
    for (std::size_t j = 0; j <= i; ++j) out.H(row, right + static_cast<Eigen::Index>(j)) = from.D[i * N + j];
    out.gradient[row] = from.G[i * from.width + gradient];
  }
  out.H = out.H.selfadjointView<Eigen::Lower>();
}

/// Calls work(block) with the size of a state's block known to the compiler.
template <class Work>
auto with_block(int size, Work&& work) {
  switch (size) {
    case 3: return work(std::integral_constant<int, 3>());
    case 4: return work(std::integral_constant<int, 4>());
    case 6: return work(std::integral_constant<int, 6>());
    default: return work(std::integral_constant<int, 7>());
  }
}

}  // namespace

double ChainReduction::reduce(const Segment& segment, const SharedState& state, const RobustLoss& loss,
                              const std::vector<int>& place, int threads, ReducedSystem& system) const {
  return with_block(paths_.trajectory().block_size(), [&]<int N>(std::integral_constant<int, N>) {
    return reduce_segment<N>(paths_, segment, state, loss, place, threads, system);
  });
}

void ChainReduction::reduce_open(const Segment& segment, const SharedState& state, const RobustLoss& loss,
                                 const std::vector<int>& place, std::size_t columns, OpenChain& out) const {
  with_block(paths_.trajectory().block_size(), [&]<int N>(std::integral_constant<int, N>) {
    reduce_open_segment<N>(paths_, segment, state, loss, place, columns, out);
  });
}

}  // namespace octant::calib
