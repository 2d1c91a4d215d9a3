// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/chain/chain_kernel.h"

#include <algorithm>

#include <Eigen/Core>

#include "models/trajectory/chain_solver.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calib/chain/chain_kernel.cc"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octant::calib {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kBorderPad>;
using V = hn::Vec<D>;

template <int N>
HWY_INLINE void raise(double* A, double floor) {
  double largest = 0.0;
  for (int i = 0; i < N; ++i) largest = std::max(largest, A[i * N + i]);
  for (int i = 0; i < N; ++i) A[i * N + i] += floor * (1.0 + largest);
}

/// Cholesky factor of a state's block; if it is not positive definite, its diagonal is raised first.
template <int N>
HWY_INLINE SmallCholesky<N> factor(double* A, double spare_floor) {
  using Block = Eigen::Map<const Eigen::Matrix<double, N, N, Eigen::RowMajor>>;
  SmallCholesky<N> out;
  if (out.factor(Block(A))) return out;
  raise<N>(A, 100 * spare_floor);
  if (out.factor(Block(A))) return out;
  for (int i = 0; i < N; ++i)  // nothing is left of it: it is held
    for (int j = 0; j <= i; ++j) out.L[i][j] = 0.0;
  return out;
}

/// A -= B'C, all N x N.
template <int N>
HWY_INLINE void subtract_product(const double (&B)[N][N], const double (&C)[N][N], double* A) {
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j) {
      double sum = 0.0;
      for (int k = 0; k < N; ++k) sum += B[k][i] * C[k][j];
      A[i * N + j] -= sum;
    }
}

/// L^-1 A, or of its transpose.
template <int N>
HWY_INLINE void solve_block(const SmallCholesky<N>& factor, const double* A, bool transposed,
                            double (&W)[N][N]) {
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < N; ++i) {
      double sum = transposed ? A[j * N + i] : A[i * N + j];
      for (int k = 0; k < i; ++k) sum -= factor.L[i][k] * W[k][j];
      W[i][j] = sum * factor.L[i][i];
    }
}

/// Eliminates states that only the gradient column of the border touches, between two others. They are
/// eliminated first, onto these two alone, so that the border has only states that observe it.
/// @param first, last  the first of them, and the one behind them
template <int N>
HWY_INLINE void eliminate_plain(const ChainWindow& w, std::size_t first, std::size_t last,
                                double spare_floor) {
  constexpr std::size_t n = N;
  const auto gradient = [&w](std::size_t k, int i) -> double& {
    return w.G[(k * n + static_cast<std::size_t>(i)) * w.width + w.gradient];
  };
  double* const before = w.D + (first - 1) * n * n;
  double* const U = w.U + (first - 1) * n * n;  // from the state before to the one at hand
  for (std::size_t k = first; k < last; ++k) {
    const SmallCholesky<N> L = factor<N>(w.D + k * n * n, spare_floor);
    double W[N][N], Z[N][N], y[N];
    solve_block<N>(L, w.U + k * n * n, false, W);
    solve_block<N>(L, U, true, Z);
    for (int i = 0; i < N; ++i) y[i] = gradient(k, i);
    L.forward(y);
    subtract_product<N>(Z, Z, before);
    subtract_product<N>(W, W, w.D + (k + 1) * n * n);
    std::fill(U, U + n * n, 0.0);
    subtract_product<N>(Z, W, U);
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        gradient(first - 1, i) -= Z[j][i] * y[j];
        gradient(k + 1, i) -= W[j][i] * y[j];
      }
      w.H[w.gradient * w.width + w.gradient] -= y[i] * y[i];
    }
  }
}

/// Eliminates one state onto its successor.
/// @param Y  L^-1 G, may be where G is
template <int N>
HWY_INLINE void eliminate_state(double* A, const double* U, const double* G, double* Y, double* A_next,
                                double* G_next, std::size_t width, double spare_floor) {
  const SmallCholesky<N> factored = factor<N>(A, spare_floor);
  const auto& L = factored.L;
  double W[N][N];
  if (U != nullptr) {
    solve_block<N>(factored, U, false, W);
    subtract_product<N>(W, W, A_next);
  }
  const D d;
  for (std::size_t c = 0; c < width; c += hn::Lanes(d)) {
    V y[N];
    for (int i = 0; i < N; ++i) {
      V v = hn::Load(d, G + static_cast<std::size_t>(i) * width + c);
      for (int k = 0; k < i; ++k) v = hn::NegMulAdd(hn::Set(d, L[i][k]), y[k], v);
      y[i] = hn::Mul(v, hn::Set(d, L[i][i]));
      hn::Store(y[i], d, Y + static_cast<std::size_t>(i) * width + c);
    }
    if (U == nullptr) continue;
    for (int i = 0; i < N; ++i) {
      double* to = G_next + static_cast<std::size_t>(i) * width + c;
      V v = hn::Load(d, to);
      for (int k = 0; k < N; ++k) v = hn::NegMulAdd(hn::Set(d, W[k][i]), y[k], v);
      hn::Store(v, d, to);
    }
  }
}

/// H -= Y'Y, its lower triangle in blocks of 4 rows and two vectors.
HWY_INLINE void subtract_squares(const double* Y, std::size_t rows, std::size_t width, double* H) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t i = 0; i < width; i += 4) {
    std::size_t j = 0;
    for (; j <= i + 3; j += 2 * lanes) {
      const bool two = j + lanes < width && j + lanes <= i + 3;
      const std::size_t second = two ? j + lanes : j;
      V a0 = hn::Zero(d), a1 = a0, a2 = a0, a3 = a0, b0 = a0, b1 = a0, b2 = a0, b3 = a0;
      const double* y = Y;
      for (std::size_t r = 0; r < rows; ++r, y += width) {
        const V p = hn::Load(d, y + j), q = hn::Load(d, y + second);
        const V s0 = hn::Set(d, y[i]), s1 = hn::Set(d, y[i + 1]), s2 = hn::Set(d, y[i + 2]),
                s3 = hn::Set(d, y[i + 3]);
        a0 = hn::MulAdd(s0, p, a0);
        a1 = hn::MulAdd(s1, p, a1);
        a2 = hn::MulAdd(s2, p, a2);
        a3 = hn::MulAdd(s3, p, a3);
        b0 = hn::MulAdd(s0, q, b0);
        b1 = hn::MulAdd(s1, q, b1);
        b2 = hn::MulAdd(s2, q, b2);
        b3 = hn::MulAdd(s3, q, b3);
      }
      const auto take = [&](V sum, std::size_t row, std::size_t column) {
        double* h = H + row * width + column;
        hn::Store(hn::Sub(hn::Load(d, h), sum), d, h);
      };
      take(a0, i, j);
      take(a1, i + 1, j);
      take(a2, i + 2, j);
      take(a3, i + 3, j);
      if (!two) continue;
      take(b0, i, second);
      take(b1, i + 1, second);
      take(b2, i + 2, second);
      take(b3, i + 3, second);
    }
  }
}

template <int N>
HWY_INLINE void eliminate_states(const ChainWindow& w, double floor_of_last, double spare_floor) {
  constexpr std::size_t n = N;
  std::size_t rows = 0;  // of Y, which close ranks
  for (std::size_t k = 0; k < w.states;) {
    const bool is_last = k + 1 == w.states && floor_of_last > 0;
    std::size_t next = k + 1;
    while (w.is_plain != nullptr && next < w.states && w.is_plain[next] != 0 &&
           !(floor_of_last > 0 && next + 1 == w.states))
      ++next;
    if (next > k + 1) eliminate_plain<N>(w, k + 1, next, spare_floor);
    double* A = w.D + k * n * n;
    if (is_last) raise<N>(A, floor_of_last);
    eliminate_state<N>(A, is_last ? nullptr : w.U + k * n * n, w.G + k * n * w.width, w.G + rows * w.width,
                       w.D + next * n * n, w.G + next * n * w.width, w.width, spare_floor);
    rows += n;
    k = next;
  }
  subtract_squares(w.G, rows, w.width, w.H);
}

void eliminate_window(const ChainWindow& w, double floor_of_last, double spare_floor) {
  switch (w.block) {
    case 3: return eliminate_states<3>(w, floor_of_last, spare_floor);
    case 4: return eliminate_states<4>(w, floor_of_last, spare_floor);
    case 6: return eliminate_states<6>(w, floor_of_last, spare_floor);
    default: return eliminate_states<7>(w, floor_of_last, spare_floor);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace octant::calib
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::calib {

HWY_EXPORT(eliminate_window);

void eliminate(const ChainWindow& window, double floor_of_last, double spare_floor) {
  HWY_DYNAMIC_DISPATCH(eliminate_window)(window, floor_of_last, spare_floor);
}

}  // namespace octant::calib
#endif
