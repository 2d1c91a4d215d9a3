// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Private to survey/: symmetric matrices of a few rows, a pose a lane, packed by rows of the upper triangle.
// Compiled once for each instruction set, within map_kernel.cc and layer_sigma.cc.
#if defined(OCTANT_SURVEY_GEOMETRY_PACKED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTANT_SURVEY_GEOMETRY_PACKED_INL_H_
#undef OCTANT_SURVEY_GEOMETRY_PACKED_INL_H_
#else
#define OCTANT_SURVEY_GEOMETRY_PACKED_INL_H_
#endif

#include <limits>

#include "models/support/vector-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octant::survey {
namespace HWY_NAMESPACE {

using namespace octant::HWY_NAMESPACE;  // NOLINT(google-build-using-namespace): this instruction set's
using V = Vector;

constexpr double kSingular = 1e-10;     ///< smallest ratio of a pivot to its diagonal element
constexpr double kWorstDilution = 1e4;  ///< beyond it a geometry is singular to rounding, or as good as
constexpr double kNever = std::numeric_limits<double>::infinity();

/// The inverse of a packed symmetric matrix, by Cholesky; lanes where it is singular come out with `sound`
/// off.
template <int N>
HWY_INLINE void invert(const V* packed, V* inverse, Mask& sound) {
  V A[N][N], L[N][N];
  for (int p = 0, e = 0; p < N; ++p)
    for (int q = p; q < N; ++q, ++e) A[q][p] = packed[e];
  for (int p = 0; p < N; ++p) {
    V pivot = A[p][p];
    for (int m = 0; m < p; ++m) pivot -= L[p][m] * L[p][m];
    const Mask good = pivot > kSingular * A[p][p];
    sound = p == 0 ? good : sound & good;
    const V root = 1.0 / sqrt(select(good, pivot, 1.0));
    for (int q = p + 1; q < N; ++q) {
      V v = A[q][p];
      for (int m = 0; m < p; ++m) v -= L[q][m] * L[p][m];
      L[q][p] = v * root;
    }
    L[p][p] = root;  // kept as its inverse
  }
  // K = L^-1, row by row in place of L; then A^-1 = K'K.
  for (int p = 0; p < N; ++p)
    for (int q = p - 1; q >= 0; --q) {
      V v = 0.0;
      for (int m = q; m < p; ++m) v -= L[p][m] * (m == q ? L[q][q] : A[m][q]);
      A[p][q] = v * L[p][p];  // A's lower part is done with: it takes K
    }
  const auto K = [&](int p, int q) HWY_ATTR { return p == q ? L[p][p] : A[p][q]; };
  for (int p = 0, e = 0; p < N; ++p)
    for (int q = p; q < N; ++q, ++e) {
      V v = K(q, p) * K(q, q);
      for (int m = q + 1; m < N; ++m) v += K(m, p) * K(m, q);
      inverse[e] = v;
    }
}

constexpr int entry(int n, int p, int q) {
  return p <= q ? p * n - p * (p - 1) / 2 + (q - p) : entry(n, q, p);
}

template <int N>
HWY_INLINE void multiply(const V* packed, const V* vector, V* product) {
  for (int p = 0; p < N; ++p) {
    V v = packed[entry(N, p, 0)] * vector[0];
    for (int q = 1; q < N; ++q) v += packed[entry(N, p, q)] * vector[q];
    product[p] = v;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace octant::survey
HWY_AFTER_NAMESPACE();

#endif
