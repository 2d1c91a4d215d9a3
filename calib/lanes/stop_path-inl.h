// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Eight stops side by side: their paths' residuals and derivatives, and the normal equations of their states.
// Compiled once for each instruction set, within stop_solve.cc and stop_reduction.cc.
#if defined(OCTANT_CALIB_LANES_STOP_PATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTANT_CALIB_LANES_STOP_PATH_INL_H_
#undef OCTANT_CALIB_LANES_STOP_PATH_INL_H_
#else
#define OCTANT_CALIB_LANES_STOP_PATH_INL_H_
#endif

#include <cstddef>

#include "calib/lanes/stop_pack.h"
#include "models/support/vector-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octant::calib {
namespace HWY_NAMESPACE {

using namespace octant::HWY_NAMESPACE;  // NOLINT(google-build-using-namespace): this instruction set's
using V = Vector;

constexpr double kMinDistanceM = 1e-6;

HWY_INLINE V load(const Lanes& lanes, std::size_t part) {
  return octant::HWY_NAMESPACE::load(lanes.of + part);
}
HWY_INLINE void store(V v, Lanes& lanes, std::size_t part) {
  octant::HWY_NAMESPACE::store(v, lanes.of + part);
}

/// Constants of an evaluation.
struct Constants {
  HWY_INLINE explicit Constants(const StopTables& tables) {
    k = 1.0 / tables.sigma_s;
    by_offset = -1.0 / (tables.sigma_s * tables.nominal_speed_mps);
    late2 = tables.late_scale * tables.late_scale;
    early2 = tables.early_scale * tables.early_scale;
    inverse_late2 = 1.0 / late2;
    inverse_early2 = 1.0 / early2;
    inverse_speed = 1.0 / tables.speed_mps;
  }
  V k, by_offset, late2, early2, inverse_late2, inverse_early2, inverse_speed;
};

/// States of some lanes, their headings turned into a rotation.
struct View {
  V state[4], sine, cosine;
  HWY_INLINE View(const StopStates& states, std::size_t part) {
    for (int i = 0; i < 4; ++i) state[i] = load(states.value[i], part);
    turn();
  }
  HWY_INLINE void turn() {
    sine = sin(state[2]);
    cosine = cos(state[2]);
  }
};

/// Where a receiver is, in all lanes.
struct Antenna {
  HWY_INLINE Antenna(const StopTables& tables, std::size_t receiver, const View& view,
                     const Constants& constants) {
    const double* o = tables.receiver + 4 * receiver;
    const V ox = o[0], oy = o[1];
    rx = view.cosine * ox - view.sine * oy;
    ry = view.sine * ox + view.cosine * oy;
    x = view.state[0] + rx;
    y = view.state[1] + ry;
    z_m = o[2];
    delay_s = o[3];
    if (tables.has_offset) delay_s += view.state[3] * (1.0 / tables.nominal_speed_mps);
    k = constants.k;
  }
  V rx, ry;  ///< lever arm, turned
  V x, y, delay_s, k;
  double z_m;
};

/// One path in all lanes.
struct PathSight {
  V residual, weight, distance, inverse_speed;
  V rho;   ///< value of the robust loss; otherwise the square of the residual
  V v[3];  ///< derivative of the residual by the receiver's position: -(unit vector) / (c sigma)
};

/// The measurement equation (models/README.md) and its loss.
template <bool kRobust>
HWY_INLINE PathSight sight_along(const StopTables& tables, const StopPack& pack, std::size_t slot,
                                 std::size_t part, const Antenna& antenna, const Constants& constants) {
  const double* b = tables.beacon + std::ptrdiff_t{4} * pack.beacons[pack.slot[slot].beacon];
  const V tof_s = load(pack.tof_s[slot], part);
  const Mask heard = tof_s == tof_s;
  PathSight s;
  s.inverse_speed = constants.inverse_speed;
  if (pack.model_speed_mps != nullptr)
    s.inverse_speed = 1.0 / (load(pack.model_speed_mps[slot], part) + tables.speed_offset_mps);
  const V dx = antenna.x - b[0], dy = antenna.y - b[1], dz = antenna.z_m - b[2];
  s.distance = max(sqrt(dx * dx + (dy * dy + dz * dz)), kMinDistanceM);
  const V delay_s = antenna.delay_s + b[3];
  s.residual = only(heard, antenna.k * (tof_s - delay_s - s.distance * s.inverse_speed));
  if constexpr (kRobust) {  // Cauchy's loss on either side: rho and its derivative by the square
    const Mask late = s.residual > 0.0;
    const V t = s.residual * s.residual * select(late, constants.inverse_late2, constants.inverse_early2);
    s.rho = select(late, constants.late2, constants.early2) * log1p(t);
    s.weight = only(heard, 1.0 / (1.0 + t));
  } else {
    s.weight = only(heard, 1.0);
  }
  const V by_range = -(antenna.k * s.inverse_speed / s.distance);
  s.v[0] = by_range * dx;
  s.v[1] = by_range * dy;
  s.v[2] = by_range * dz;
  return s;
}

/// Normal equations of the states, one epoch a lane.
struct StopNormal {
  V A[4][4];  ///< lower triangle
  V g[4];
  V bend;  ///< contribution of the curvature of the ranges over the heading to A[2][2] of the full Hessian
  V cost;
  HWY_INLINE void clear() {
    for (auto& row : A)
      for (V& v : row) v = 0.0;
    for (V& v : g) v = 0.0;
    bend = cost = 0.0;
  }
  /// Takes over another's in some lanes.
  template <int n>
  HWY_INLINE void assign_where(Mask lanes, const StopNormal& other) {
    for (int p = 0; p < n; ++p) {
      for (int q = 0; q <= p; ++q) A[p][q] = select(lanes, other.A[p][q], A[p][q]);
      g[p] = select(lanes, other.g[p], g[p]);
    }
    bend = select(lanes, other.bend, bend);
    cost = select(lanes, other.cost, cost);
  }
};

/// Sums over a receiver's paths of w v v' and w r v in the plane, and of w v, w, w r.
struct PlaneMoments {
  V v00, v01, v11, r0, r1, w0, w1, w, r;
};

/// Adds a receiver's paths from their moments. The derivative by the state is (v0, v1, rx v1 - ry v0,
/// offset).
template <bool kOffset>
HWY_INLINE void add_receiver(const Antenna& a, const Constants& constants, const PlaneMoments& m,
                             StopNormal& out) {
  const V h0 = a.rx * m.v01 - a.ry * m.v00, h1 = a.rx * m.v11 - a.ry * m.v01;
  out.A[0][0] += m.v00;
  out.A[1][0] += m.v01;
  out.A[1][1] += m.v11;
  out.A[2][0] += h0;
  out.A[2][1] += h1;
  out.A[2][2] += V(a.rx * h1 - a.ry * h0);
  out.g[0] += m.r0;
  out.g[1] += m.r1;
  out.g[2] += V(a.rx * m.r1 - a.ry * m.r0);
  out.bend = out.bend - a.ry * m.r1 - a.rx * m.r0;
  if constexpr (kOffset) {
    const V e = constants.by_offset;
    out.A[3][0] += e * m.w0;
    out.A[3][1] += e * m.w1;
    out.A[3][2] += e * (a.rx * m.w1 - a.ry * m.w0);
    out.A[3][3] += e * e * m.w;
    out.g[3] += e * m.r;
  }
}

/// Adds measured poses; their cost is doubled, like that of the paths so far.
HWY_INLINE void add_poses(const StopPack& pack, std::size_t part, const View& view, StopNormal& out) {
  for (int p = 0; p < 3; ++p) {
    const V weight = load(pack.poses->weight[p], part);
    V off = view.state[p] - load(pack.poses->value[p], part);
    if (p == 2) {
      constexpr double kTurn = 6.283185307179586476925287;
      off -= kTurn * round(off * (1.0 / kTurn));
    }
    out.A[p][p] += weight;
    out.g[p] += weight * off;
    out.cost += weight * off * off;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace octant::calib
HWY_AFTER_NAMESPACE();

#endif
