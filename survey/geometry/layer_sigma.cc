// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/layer_sigma.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "survey/geometry/layer_sigma.cc"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set
#include <hwy/highway.h>

#include "survey/geometry/map_kernel.h"
#include "survey/geometry/packed-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octant::survey {
namespace HWY_NAMESPACE {

/// Eliminates the unknowns behind x and y, last ones first, and inverts what is left.
template <int N>
HWY_INLINE V horizontal_sigma(V* A, const V* before) {
  Mask sound = V(0.0) == 0.0;
  for (int m = N - 1; m >= 2; --m) {
    const V pivot = A[entry(N, m, m)];
    const Mask good = pivot > kSingular * before[m];
    sound = sound & good;
    const V inverse = 1.0 / select(good, pivot, 1.0);
    for (int p = 0; p < m; ++p) {
      const V factor = A[entry(N, p, m)] * inverse;
      for (int q = p; q < m; ++q) A[entry(N, p, q)] = A[entry(N, p, q)] - factor * A[entry(N, q, m)];
    }
  }
  const V xx = A[0], xy = A[1], yy = A[entry(N, 1, 1)];
  const V determinant = xx * yy - xy * xy;
  const Mask good = (xx > kSingular * before[0]) & (determinant > kSingular * before[1] * xx);
  sound = sound & good;
  const V square = (xx + yy) / select(sound, determinant, 1.0);
  // The number of ranges, with their mean weight: the square of the dilution times their number.
  sound = sound & (square * (before[0] + before[1]) < 10 * kWorstDilution * kWorstDilution);
  return select(sound, sqrt(max(square, 0.0)), kNever);
}

template <int N>
HWY_INLINE void sigma_of_packed_n(const double* information, const double* less, const double* less_too,
                                  std::size_t stride, std::size_t count, double* sigma_m) {
  constexpr int E = N * (N + 1) / 2;
  const std::size_t lanes = lanes_at_once();
  alignas(64) double padded[3][E][kMapLanes];
  for (std::size_t at = 0; at < count; at += lanes) {
    const bool tail = at + lanes > count;
    if (tail)  // the last few are copied to where there is room behind them
      for (int e = 0; e < E; ++e)
        for (std::size_t i = 0; i < lanes; ++i) {
          const std::size_t from = static_cast<std::size_t>(e) * stride + std::min(at + i, count - 1);
          padded[0][e][i] = information[from];
          padded[1][e][i] = less != nullptr ? less[from] : 0.0;
          padded[2][e][i] = less_too != nullptr ? less_too[from] : 0.0;
        }
    const auto load = [&](const double* values, int which, int e) HWY_ATTR {
      return tail ? load_unaligned(padded[which][e])
                  : load_unaligned(values + static_cast<std::size_t>(e) * stride + at);
    };
    V A[E], before[N];
    for (int e = 0; e < E; ++e) A[e] = load(information, 0, e);
    for (int p = 0; p < N; ++p) before[p] = A[entry(N, p, p)];
    if (less != nullptr)
      for (int e = 0; e < E; ++e) A[e] = A[e] - load(less, 1, e);
    if (less_too != nullptr)
      for (int e = 0; e < E; ++e) A[e] = A[e] - load(less_too, 2, e);
    const V sigma = horizontal_sigma<N>(A, before);
    if (!tail) {
      store_unaligned(sigma, sigma_m + at);
    } else {
      alignas(64) double last[kMapLanes];
      store(sigma, last);
      std::copy(last, last + (count - at), sigma_m + at);
    }
  }
}

void sigma_of_packed_in_lanes(int unknowns, const double* information, const double* less,
                              const double* less_too, std::size_t stride, std::size_t count,
                              double* sigma_m) {
  switch (unknowns) {
    case 2: return sigma_of_packed_n<2>(information, less, less_too, stride, count, sigma_m);
    case 3: return sigma_of_packed_n<3>(information, less, less_too, stride, count, sigma_m);
    case 4: return sigma_of_packed_n<4>(information, less, less_too, stride, count, sigma_m);
    case 6: return sigma_of_packed_n<6>(information, less, less_too, stride, count, sigma_m);
    default: return sigma_of_packed_n<7>(information, less, less_too, stride, count, sigma_m);
  }
}

void add_to_in_lanes(const double* term, std::size_t count, double* sum) {
  const std::size_t lanes = lanes_at_once();
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    store_unaligned(load_unaligned(term + i) + load_unaligned(sum + i), sum + i);
  for (; i < count; ++i) sum[i] += term[i];
}

}  // namespace HWY_NAMESPACE
}  // namespace octant::survey
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::survey {

HWY_EXPORT(sigma_of_packed_in_lanes);
HWY_EXPORT(add_to_in_lanes);

void sigma_of_packed(int unknowns, const double* information, const double* less, const double* less_too,
                     std::size_t stride, std::size_t count, double* sigma_m) {
  HWY_DYNAMIC_DISPATCH(sigma_of_packed_in_lanes)
  (unknowns, information, less, less_too, stride, count, sigma_m);
}

void add_to(const double* term, std::size_t count, double* sum) {
  HWY_DYNAMIC_DISPATCH(add_to_in_lanes)(term, count, sum);
}

}  // namespace octant::survey
#endif
