// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/chain/chain_kernel.h"

#include <algorithm>
#include <cmath>

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

/// Cholesky factor, the reciprocals of its diagonal on the diagonal.
template <int N>
HWY_INLINE bool factor(const double* A, double (&L)[N][N]) {
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = A[i * N + j];
      for (int k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      if (j < i) {
        L[i][j] = sum * L[j][j];
      } else if (sum > 0) {
        L[i][i] = 1.0 / std::sqrt(sum);
      } else {
        return false;
      }
    }
  }
  return true;
}

template <int N>
HWY_INLINE void raise(double* A, double floor) {
  double largest = 0.0;
  for (int i = 0; i < N; ++i) largest = std::max(largest, A[i * N + i]);
  for (int i = 0; i < N; ++i) A[i * N + i] += floor * (1.0 + largest);
}

/// One state: its G becomes Y, what follows takes what it passes on.
template <int N>
HWY_INLINE void eliminate_state(double* A, const double* U, double* G, double* A_next, double* G_next,
                                std::size_t width, double spare_floor) {
  double L[N][N], W[N][N];
  if (!factor<N>(A, L)) {
    raise<N>(A, 100 * spare_floor);
    if (!factor<N>(A, L)) {  // nothing is left of it: it is held
      for (int i = 0; i < N; ++i)
        for (int j = 0; j <= i; ++j) L[i][j] = 0.0;
    }
  }
  if (U != nullptr) {
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i) {
        double sum = U[i * N + j];
        for (int k = 0; k < i; ++k) sum -= L[i][k] * W[k][j];
        W[i][j] = sum * L[i][i];
      }
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j) {
        double sum = 0.0;
        for (int k = 0; k < N; ++k) sum += W[k][i] * W[k][j];
        A_next[i * N + j] -= sum;
      }
  }
  const D d;
  for (std::size_t c = 0; c < width; c += hn::Lanes(d)) {
    V y[N];
    for (int i = 0; i < N; ++i) {
      V v = hn::Load(d, G + static_cast<std::size_t>(i) * width + c);
      for (int k = 0; k < i; ++k) v = hn::NegMulAdd(hn::Set(d, L[i][k]), y[k], v);
      y[i] = hn::Mul(v, hn::Set(d, L[i][i]));
      hn::Store(y[i], d, G + static_cast<std::size_t>(i) * width + c);
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
  for (std::size_t k = 0; k < w.states; ++k) {
    double* A = w.D + k * n * n;
    const bool is_last = k + 1 == w.states && floor_of_last > 0;
    if (is_last) raise<N>(A, floor_of_last);
    eliminate_state<N>(A, is_last ? nullptr : w.U + k * n * n, w.G + k * n * w.width, A + n * n,
                       w.G + (k + 1) * n * w.width, w.width, spare_floor);
  }
  subtract_squares(w.G, w.states * n, w.width, w.H);
}

void eliminate_window(const ChainWindow& w, double floor_of_last, double spare_floor) {
  switch (w.block) {
    case 3: return eliminate_states<3>(w, floor_of_last, spare_floor);
    case 4: return eliminate_states<4>(w, floor_of_last, spare_floor);
    case 6: return eliminate_states<6>(w, floor_of_last, spare_floor);
    default: return eliminate_states<7>(w, floor_of_last, spare_floor);
  }
}

const char* chain_target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace octant::calib
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::calib {

HWY_EXPORT(eliminate_window);
HWY_EXPORT(chain_target_name);

void eliminate(const ChainWindow& window, double floor_of_last, double spare_floor) {
  HWY_DYNAMIC_DISPATCH(eliminate_window)(window, floor_of_last, spare_floor);
}

const char* chain_kernel_target() { return HWY_DYNAMIC_DISPATCH(chain_target_name)(); }

}  // namespace octant::calib
#endif
