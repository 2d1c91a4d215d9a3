// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/stop_kernel.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calib/adjust/stop_kernel.cc"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace octant::calib {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kLanes>;
using V = hn::Vec<D>;

/// Steps and limits of `settle` in models/settle.cc.
constexpr int kMaxIterations = 30;
constexpr double kAtRest = 1e-13;
/// With plain squares a step that gains less than this share of the cost is taken without looking again: what
/// would be left to gain after it is smaller by the square of residual over distance.
constexpr double kLastStep = 1e-6;
constexpr double kMinDistanceM = 1e-6;

HWY_INLINE V load(const Lanes& lanes, std::size_t part) { return hn::Load(D(), lanes.of + part); }
HWY_INLINE void store(V v, Lanes& lanes, std::size_t part) { hn::Store(v, D(), lanes.of + part); }

/// Adds up the lanes of four vectors, each onto its own sum.
HWY_INLINE void add_lanes(V a, V b, V c, V e, double* sums) {
#if HWY_MAX_BYTES >= 32
  const hn::CappedTag<double, 4> d4;
#if HWY_MAX_BYTES >= 64
  const auto narrow = [d4](V v) { return hn::Add(hn::LowerHalf(d4, v), hn::UpperHalf(d4, v)); };
#else
  const auto narrow = [](V v) { return v; };
#endif
  const auto a4 = narrow(a), b4 = narrow(b), c4 = narrow(c), e4 = narrow(e);
  const auto ab = hn::Add(hn::InterleaveLower(d4, a4, b4), hn::InterleaveUpper(d4, a4, b4));
  const auto ce = hn::Add(hn::InterleaveLower(d4, c4, e4), hn::InterleaveUpper(d4, c4, e4));
  const auto all = hn::Add(hn::ConcatLowerLower(d4, ce, ab), hn::ConcatUpperUpper(d4, ce, ab));
  hn::StoreU(hn::Add(hn::LoadU(d4, sums), all), d4, sums);
#else
  const V all[4] = {a, b, c, e};
  for (int i = 0; i < 4; ++i) sums[i] += hn::GetLane(hn::SumOfLanes(D(), all[i]));
#endif
}

/// Constants of an evaluation.
struct Constants {
  HWY_INLINE explicit Constants(const StopTables& tables) {
    const D d;
    const V one = hn::Set(d, 1.0);
    k = hn::Set(d, 1.0 / tables.sigma_s);
    by_offset = hn::Set(d, -1.0 / (tables.sigma_s * tables.nominal_speed_mps));
    late2 = hn::Set(d, tables.late_scale * tables.late_scale);
    early2 = hn::Set(d, tables.early_scale * tables.early_scale);
    inverse_late2 = hn::Div(one, late2);
    inverse_early2 = hn::Div(one, early2);
    inverse_speed = hn::Set(d, 1.0 / tables.speed_mps);
  }
  V k, by_offset, late2, early2, inverse_late2, inverse_early2, inverse_speed;
};

/// States of some lanes, their headings turned into a rotation.
struct View {
  V state[4], sine, cosine;
  HWY_INLINE void turn() {
    sine = hn::Sin(D(), state[2]);
    cosine = hn::Cos(D(), state[2]);
  }
};

/// Where a receiver is, in all lanes.
struct Antenna {
  HWY_INLINE Antenna(const StopTables& tables, std::size_t receiver, const View& view,
                     const Constants& constants) {
    const D d;
    const double* o = tables.receiver + 4 * receiver;
    const V ox = hn::Set(d, o[0]), oy = hn::Set(d, o[1]);
    rx = hn::NegMulAdd(view.sine, oy, hn::Mul(view.cosine, ox));
    ry = hn::MulAdd(view.sine, ox, hn::Mul(view.cosine, oy));
    x = hn::Add(view.state[0], rx);
    y = hn::Add(view.state[1], ry);
    z_m = o[2];
    delay_s = hn::Set(d, o[3]);
    if (tables.has_offset)
      delay_s = hn::MulAdd(view.state[3], hn::Set(d, 1.0 / tables.nominal_speed_mps), delay_s);
    k = constants.k;
  }
  V rx, ry;  ///< lever arm, turned
  V x, y, delay_s, k;
  double z_m;
};

/// One path in all lanes.
struct Sight {
  V residual, weight, rho, distance, inverse_speed;
  V v[3];  ///< of the residual by the place of the receiver: -(unit vector) / (c sigma)
};

template <bool kRobust>
HWY_INLINE Sight look(const StopTables& tables, const StopPack& pack, std::size_t slot, std::size_t part,
                      const Antenna& antenna, const Constants& constants) {
  const D d;
  const double* b = tables.beacon + std::ptrdiff_t{4} * pack.beacons[pack.slot[slot].beacon];
  const V tof_s = load(pack.tof_s[slot], part);
  const auto heard = hn::Eq(tof_s, tof_s);
  Sight s;
  s.inverse_speed = constants.inverse_speed;
  if (pack.model_speed_mps != nullptr)
    s.inverse_speed = hn::Div(hn::Set(d, 1.0), hn::Add(load(pack.model_speed_mps[slot], part),
                                                       hn::Set(d, tables.speed_offset_mps)));
  const V dx = hn::Sub(antenna.x, hn::Set(d, b[0])), dy = hn::Sub(antenna.y, hn::Set(d, b[1])),
          dz = hn::Set(d, antenna.z_m - b[2]);
  s.distance =
      hn::Max(hn::Sqrt(hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)))), hn::Set(d, kMinDistanceM));
  const V delay_s = hn::Add(antenna.delay_s, hn::Set(d, b[3]));
  s.residual = hn::IfThenElseZero(
      heard, hn::Mul(antenna.k, hn::NegMulAdd(s.distance, s.inverse_speed, hn::Sub(tof_s, delay_s))));
  const V square = hn::Mul(s.residual, s.residual);
  if constexpr (kRobust) {  // Cauchy's loss on either side: rho and its derivative by the square
    const auto late = hn::Gt(s.residual, hn::Zero(d));
    const V t = hn::Mul(square, hn::IfThenElse(late, constants.inverse_late2, constants.inverse_early2));
    s.rho = hn::Mul(hn::IfThenElse(late, constants.late2, constants.early2), hn::Log1p(d, t));
    s.weight = hn::IfThenElseZero(heard, hn::Div(hn::Set(d, 1.0), hn::Add(hn::Set(d, 1.0), t)));
  } else {
    s.rho = square;
    s.weight = hn::IfThenElseZero(heard, hn::Set(d, 1.0));
  }
  const V by_range = hn::Neg(hn::Div(hn::Mul(antenna.k, s.inverse_speed), s.distance));
  s.v[0] = hn::Mul(by_range, dx);
  s.v[1] = hn::Mul(by_range, dy);
  s.v[2] = hn::Mul(by_range, dz);
  return s;
}

/// Normal equations of the states, one epoch a lane.
struct Normal {
  V A[4][4];  ///< lower triangle
  V g[4];
  V bend;  ///< what the bend of the ranges over the heading adds to A[2][2] of the full Hessian
  V cost;
  HWY_INLINE void clear() {
    const V zero = hn::Zero(D());
    for (auto& row : A)
      for (V& v : row) v = zero;
    for (V& v : g) v = zero;
    bend = zero;
    cost = zero;
  }
};

/// Adds a receiver's paths from their moments. The derivative by the state is (v0, v1, rx v1 - ry v0,
/// offset).
template <bool kOffset>
HWY_INLINE void add_receiver(const Antenna& a, const Constants& constants, V v00, V v01, V v11, V r0, V r1,
                             V w0, V w1, V w, V r, Normal& out) {
  const V h0 = hn::NegMulAdd(a.ry, v00, hn::Mul(a.rx, v01)),
          h1 = hn::NegMulAdd(a.ry, v01, hn::Mul(a.rx, v11));
  out.A[0][0] = hn::Add(out.A[0][0], v00);
  out.A[1][0] = hn::Add(out.A[1][0], v01);
  out.A[1][1] = hn::Add(out.A[1][1], v11);
  out.A[2][0] = hn::Add(out.A[2][0], h0);
  out.A[2][1] = hn::Add(out.A[2][1], h1);
  out.A[2][2] = hn::Add(out.A[2][2], hn::NegMulAdd(a.ry, h0, hn::Mul(a.rx, h1)));
  out.g[0] = hn::Add(out.g[0], r0);
  out.g[1] = hn::Add(out.g[1], r1);
  out.g[2] = hn::Add(out.g[2], hn::NegMulAdd(a.ry, r0, hn::Mul(a.rx, r1)));
  out.bend = hn::NegMulAdd(a.rx, r0, hn::NegMulAdd(a.ry, r1, out.bend));
  if constexpr (kOffset) {
    const V e = constants.by_offset;
    out.A[3][0] = hn::MulAdd(e, w0, out.A[3][0]);
    out.A[3][1] = hn::MulAdd(e, w1, out.A[3][1]);
    out.A[3][2] = hn::MulAdd(e, hn::NegMulAdd(a.ry, w0, hn::Mul(a.rx, w1)), out.A[3][2]);
    out.A[3][3] = hn::MulAdd(hn::Mul(e, e), w, out.A[3][3]);
    out.g[3] = hn::MulAdd(e, r, out.g[3]);
  }
}

/// Adds measured poses; their cost is twice what it counts, as that of the paths so far.
HWY_INLINE void add_poses(const StopPack& pack, std::size_t part, const View& view, Normal& out) {
  const D d;
  for (int p = 0; p < 3; ++p) {
    const V weight = load(pack.poses->weight[p], part);
    V off = hn::Sub(view.state[p], load(pack.poses->value[p], part));
    if (p == 2) {
      constexpr double kTurn = 6.283185307179586476925287;
      off = hn::NegMulAdd(hn::Set(d, kTurn), hn::Round(hn::Mul(off, hn::Set(d, 1.0 / kTurn))), off);
    }
    out.A[p][p] = hn::Add(out.A[p][p], weight);
    out.g[p] = hn::MulAdd(weight, off, out.g[p]);
    out.cost = hn::MulAdd(hn::Mul(weight, off), off, out.cost);
  }
}

template <bool kOffset, bool kRobust>
HWY_INLINE void build(const StopTables& tables, const StopPack& pack, std::size_t part, const View& view,
                      const Constants& constants, Normal& out) {
  const V zero = hn::Zero(D());
  out.clear();
  for (std::size_t slot = 0; slot < pack.slots;) {
    const std::size_t receiver = pack.slot[slot].receiver;
    const Antenna antenna(tables, receiver, view, constants);
    V v00 = zero, v01 = zero, v11 = zero, r0 = zero, r1 = zero, w0 = zero, w1 = zero, w = zero, r = zero;
    for (; slot < pack.slots && pack.slot[slot].receiver == receiver; ++slot) {
      const Sight s = look<kRobust>(tables, pack, slot, part, antenna, constants);
      out.cost = hn::Add(out.cost, s.rho);
      const V wv0 = hn::Mul(s.weight, s.v[0]), wv1 = hn::Mul(s.weight, s.v[1]);
      v00 = hn::MulAdd(wv0, s.v[0], v00);
      v01 = hn::MulAdd(wv0, s.v[1], v01);
      v11 = hn::MulAdd(wv1, s.v[1], v11);
      r0 = hn::MulAdd(wv0, s.residual, r0);
      r1 = hn::MulAdd(wv1, s.residual, r1);
      if constexpr (kOffset) {
        w0 = hn::Add(w0, wv0);
        w1 = hn::Add(w1, wv1);
        w = hn::Add(w, s.weight);
        r = hn::MulAdd(s.weight, s.residual, r);
      }
    }
    add_receiver<kOffset>(antenna, constants, v00, v01, v11, r0, r1, w0, w1, w, r, out);
  }
  if (pack.poses != nullptr) add_poses(pack, part, view, out);
  out.cost = hn::Mul(out.cost, hn::Set(D(), 0.5));
}

/// Solves (A + lambda diag A + floor) s = -g by Cholesky; lanes where it is not positive definite come out
/// with `sound` off. A is that of Gauss and Newton but for the heading: a lever arm is hardly longer than the
/// residuals while the beacons are off, and steps without its bend then close in slowly. The bend counts down
/// to half of the diagonal, and not where it would turn it about: a state that far off is no case for Newton.
/// A bend that is more than the diagonal only makes steps shorter and counts in `stiff` lanes; in the others
/// the longer steps get out of a place that the loss makes up.
template <bool kOffset>
HWY_INLINE void solve(const Normal& normal, V lambda, hn::Mask<D> stiff, V* step, hn::Mask<D>& sound) {
  const D d;
  constexpr int n = kOffset ? 4 : 3;
  const V one = hn::Set(d, 1.0);
  const auto& A = normal.A;
  V L[4][4];
  V largest = A[0][0];
  for (int p = 1; p < n; ++p) largest = hn::Max(largest, A[p][p]);
  const V floor = hn::Mul(hn::Set(d, 1e-9), hn::Add(one, largest));
  V y[4];
  sound = hn::Eq(one, one);
  for (int p = 0; p < n; ++p) {
    V diagonal = A[p][p];
    if (p == 2) {
      const V bent = hn::Max(hn::Add(diagonal, normal.bend), hn::Mul(hn::Set(d, 0.5), diagonal));
      const auto counts =
          hn::And(hn::Ge(normal.bend, hn::Neg(diagonal)), hn::Or(stiff, hn::Le(normal.bend, diagonal)));
      diagonal = hn::IfThenElse(counts, bent, diagonal);
    }
    V pivot = hn::Add(hn::MulAdd(lambda, diagonal, diagonal), floor);
    for (int m = 0; m < p; ++m) pivot = hn::NegMulAdd(L[p][m], L[p][m], pivot);
    sound = hn::And(sound, hn::Gt(pivot, hn::Zero(d)));
    const V inverse = hn::Div(one, hn::Sqrt(hn::Max(pivot, hn::Set(d, 1e-300))));
    L[p][p] = inverse;  // kept as its inverse
    for (int q = p + 1; q < n; ++q) {
      V v = A[q][p];
      for (int m = 0; m < p; ++m) v = hn::NegMulAdd(L[q][m], L[p][m], v);
      L[q][p] = hn::Mul(v, inverse);
    }
    V v = hn::Neg(normal.g[p]);
    for (int m = 0; m < p; ++m) v = hn::NegMulAdd(L[p][m], y[m], v);
    y[p] = hn::Mul(v, inverse);
  }
  for (int p = n - 1; p >= 0; --p) {
    V v = y[p];
    for (int m = p + 1; m < n; ++m) v = hn::NegMulAdd(L[m][p], step[m], v);
    step[p] = hn::Mul(v, L[p][p]);
  }
}

template <bool kOffset, bool kRobust>
HWY_INLINE void settle_part(const StopTables tables, const StopPack pack, std::size_t part,
                            StopStates& states, StopOutcome& outcome) {
  const D d;
  constexpr int n = kOffset ? 4 : 3;
  const Constants constants(tables);
  View view;
  for (int i = 0; i < 4; ++i) view.state[i] = load(states.value[i], part);
  view.turn();
  Normal now, trial;
  build<kOffset, kRobust>(tables, pack, part, view, constants, now);
  V lambda = hn::Set(d, 1e-8), rest = hn::Zero(d);  // rest: 1 where nothing is left to gain
  const V one = hn::Set(d, 1.0);
  auto stiff =
      hn::Eq(one, kRobust ? hn::Zero(d)
                          : one);  // squares have one place to go, and a measured heading is near its own
  if (pack.poses != nullptr) stiff = hn::Or(stiff, hn::Gt(load(pack.poses->weight[2], part), hn::Zero(d)));
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    V step[4];
    hn::Mask<D> sound;
    solve<kOffset>(now, lambda, stiff, step, sound);
    V gain = hn::Zero(d);  // half the Newton decrement: what a quadratic cost would lose
    for (int p = 0; p < n; ++p) gain = hn::NegMulAdd(now.g[p], step[p], gain);
    gain = hn::Mul(hn::Set(d, 0.5), gain);
    const auto moving = hn::Lt(rest, one);
    rest = hn::IfThenElse(hn::And(sound, hn::Le(gain, hn::Mul(hn::Set(d, kAtRest), hn::Add(one, now.cost)))),
                          one, rest);
    if constexpr (!kRobust) {
      const auto last = hn::And(
          moving, hn::And(sound, hn::And(hn::Le(gain, hn::Mul(hn::Set(d, kLastStep), hn::Add(one, now.cost))),
                                         hn::Lt(lambda, hn::Set(d, 1e-7)))));
      for (int p = 0; p < n; ++p)
        view.state[p] = hn::IfThenElse(last, hn::Add(view.state[p], step[p]), view.state[p]);
      now.cost = hn::IfThenElse(last, hn::Sub(now.cost, gain), now.cost);
      rest = hn::IfThenElse(last, one, rest);
    }
    if (hn::AllTrue(d, hn::Eq(rest, one))) break;
    View moved = view;
    for (int p = 0; p < n; ++p)
      moved.state[p] = hn::IfThenElse(hn::Eq(rest, one), view.state[p], hn::Add(view.state[p], step[p]));
    moved.turn();
    build<kOffset, kRobust>(tables, pack, part, moved, constants, trial);
    const auto better = hn::And(
        hn::Lt(rest, one), hn::And(sound, hn::Le(trial.cost, hn::Mul(now.cost, hn::Set(d, 1.0 + 1e-14)))));
    // Neither better nor much left to gain: at rest to rounding.
    const auto rounding =
        hn::AndNot(better, hn::Lt(gain, hn::Mul(hn::Set(d, 1e-12), hn::Add(one, now.cost))));
    rest = hn::IfThenElse(rounding, one, rest);
    for (int p = 0; p < 4; ++p) view.state[p] = hn::IfThenElse(better, moved.state[p], view.state[p]);
    for (int p = 0; p < n; ++p) {
      for (int q = 0; q <= p; ++q) now.A[p][q] = hn::IfThenElse(better, trial.A[p][q], now.A[p][q]);
      now.g[p] = hn::IfThenElse(better, trial.g[p], now.g[p]);
    }
    now.bend = hn::IfThenElse(better, trial.bend, now.bend);
    now.cost = hn::IfThenElse(better, trial.cost, now.cost);
    const V calmer =
        hn::IfThenElse(hn::Lt(lambda, hn::Set(d, 1e-7)), hn::Set(d, 1e-8), hn::Mul(lambda, hn::Set(d, 0.1)));
    lambda = hn::IfThenElse(better, calmer, hn::Max(hn::Mul(lambda, hn::Set(d, 10.0)), hn::Set(d, 1e-5)));
  }
  for (int i = 0; i < 4; ++i) store(view.state[i], states.value[i], part);
  store(now.cost, outcome.cost, part);
  const auto finite = hn::Lt(hn::Abs(now.cost), hn::Set(d, 1e300));
  store(hn::IfThenElseZero(finite, rest), outcome.converged, part);
}

void settle_stops_in_lanes(const StopTables& tables, const StopPack& pack, StopStates& states,
                           StopOutcome& outcome) {
  const bool robust = tables.late_scale > 0 && tables.early_scale > 0;
  for (std::size_t part = 0; part < kLanes; part += hn::Lanes(D())) {
    if (tables.has_offset) {
      robust ? settle_part<true, true>(tables, pack, part, states, outcome)
             : settle_part<true, false>(tables, pack, part, states, outcome);
    } else {
      robust ? settle_part<false, true>(tables, pack, part, states, outcome)
             : settle_part<false, false>(tables, pack, part, states, outcome);
    }
  }
}

/// Derivative of a residual by the speed of the medium.
HWY_INLINE V by_speed_of(const Sight& s, const Constants& constants) {
  return hn::Mul(hn::Mul(constants.k, s.distance), hn::Mul(s.inverse_speed, s.inverse_speed));
}

/// Moments of some paths, in the order of StopSums::beacon.
struct Moments {
  V w, v[3], vv[6], s, sv[3], r, rv[3];
  HWY_INLINE void clear() {
    w = s = r = v[0] = v[1] = v[2] = sv[0] = sv[1] = sv[2] = rv[0] = rv[1] = rv[2] = vv[0] = vv[1] = vv[2] =
        vv[3] = vv[4] = vv[5] = hn::Zero(D());
  }
  HWY_INLINE void add(const Moments& m) {
    w = hn::Add(w, m.w);
    s = hn::Add(s, m.s);
    r = hn::Add(r, m.r);
    for (int i = 0; i < 3; ++i) {
      v[i] = hn::Add(v[i], m.v[i]);
      sv[i] = hn::Add(sv[i], m.sv[i]);
      rv[i] = hn::Add(rv[i], m.rv[i]);
    }
    for (int i = 0; i < 6; ++i) vv[i] = hn::Add(vv[i], m.vv[i]);
  }
  HWY_INLINE void add_to_sums(double* sums) const {
    const V none = hn::Zero(D());
    add_lanes(w, v[0], v[1], v[2], sums);
    add_lanes(vv[0], vv[1], vv[2], vv[3], sums + 4);
    add_lanes(vv[4], vv[5], s, r, sums + 8);
    add_lanes(sv[0], sv[1], sv[2], none, sums + 12);
    add_lanes(rv[0], rv[1], rv[2], none, sums + 16);
  }
};

HWY_INLINE Moments moments_of(const Sight& s, V by_speed) {
  Moments m;
  m.w = s.weight;
  m.s = hn::Mul(s.weight, by_speed);
  m.r = hn::Mul(s.weight, s.residual);
  for (int i = 0; i < 3; ++i) {
    m.v[i] = hn::Mul(s.weight, s.v[i]);
    m.sv[i] = hn::Mul(m.s, s.v[i]);
    m.rv[i] = hn::Mul(m.r, s.v[i]);
  }
  m.vv[0] = hn::Mul(m.v[0], s.v[0]);
  m.vv[1] = hn::Mul(m.v[0], s.v[1]);
  m.vv[2] = hn::Mul(m.v[0], s.v[2]);
  m.vv[3] = hn::Mul(m.v[1], s.v[1]);
  m.vv[4] = hn::Mul(m.v[1], s.v[2]);
  m.vv[5] = hn::Mul(m.v[2], s.v[2]);
  return m;
}

/// Couples a path to its beacon, whose derivatives are -(v, k).
template <bool kOffset>
HWY_INLINE void couple_beacon(const Moments& m, const Antenna& a, const Constants& constants,
                              std::size_t part, Lanes* coupling) {
  const V row0[4] = {m.vv[0], m.vv[1], m.vv[2], hn::Mul(constants.k, m.v[0])};
  const V row1[4] = {m.vv[1], m.vv[3], m.vv[4], hn::Mul(constants.k, m.v[1])};
  for (std::size_t c = 0; c < 4; ++c) {
    Lanes* G = coupling + 4 * c;
    store(hn::Sub(load(G[0], part), row0[c]), G[0], part);
    store(hn::Sub(load(G[1], part), row1[c]), G[1], part);
    store(hn::MulAdd(a.ry, row0[c], hn::NegMulAdd(a.rx, row1[c], load(G[2], part))), G[2], part);
    if constexpr (kOffset) {
      const V last = c < 3 ? m.v[c] : hn::Mul(constants.k, m.w);
      store(hn::NegMulAdd(constants.by_offset, last, load(G[3], part)), G[3], part);
    }
  }
}

/// Products of the derivatives by beacon, -(v, k), and by receiver, (R'v, -k).
HWY_INLINE void add_pair(const Moments& m, const Sight& s, const View& view, const Constants& constants,
                         double* pair) {
  const V by_receiver[3] = {hn::MulAdd(view.cosine, s.v[0], hn::Mul(view.sine, s.v[1])),
                            hn::NegMulAdd(view.sine, s.v[0], hn::Mul(view.cosine, s.v[1])), s.v[2]};
  const V left[4] = {hn::Neg(m.v[0]), hn::Neg(m.v[1]), hn::Neg(m.v[2]), hn::Neg(hn::Mul(constants.k, m.w))};
  const V last = hn::Neg(constants.k);
  for (std::size_t i = 0; i < 4; ++i)
    add_lanes(hn::Mul(left[i], by_receiver[0]), hn::Mul(left[i], by_receiver[1]),
              hn::Mul(left[i], by_receiver[2]), hn::Mul(left[i], last), pair + 4 * i);
}

/// A receiver's own elements and its coupling to the state, from the moments of its paths. Derivatives by the
/// receiver: (R'v, -k).
template <bool kOffset>
HWY_INLINE void finish_receiver(const Moments& m, const Antenna& a, const View& view,
                                const Constants& constants, std::size_t part, Lanes* coupling, double* own) {
  const V c = view.cosine, s = view.sine, k = constants.k;
  const auto turn0 = [&](V x, V y) { return hn::MulAdd(c, x, hn::Mul(s, y)); };
  const auto turn1 = [&](V x, V y) { return hn::NegMulAdd(s, x, hn::Mul(c, y)); };
  const V row0[4] = {turn0(m.vv[0], m.vv[1]), turn1(m.vv[0], m.vv[1]), m.vv[2], hn::Neg(hn::Mul(k, m.v[0]))};
  const V row1[4] = {turn0(m.vv[1], m.vv[3]), turn1(m.vv[1], m.vv[3]), m.vv[4], hn::Neg(hn::Mul(k, m.v[1]))};
  const V sums[4] = {turn0(m.v[0], m.v[1]), turn1(m.v[0], m.v[1]), m.v[2], hn::Neg(hn::Mul(k, m.w))};
  for (std::size_t i = 0; i < 4; ++i) {
    Lanes* G = coupling + 4 * i;
    store(row0[i], G[0], part);
    store(row1[i], G[1], part);
    store(hn::NegMulAdd(a.ry, row0[i], hn::Mul(a.rx, row1[i])), G[2], part);
    if constexpr (kOffset) store(hn::Mul(constants.by_offset, sums[i]), G[3], part);
  }
  const V minus = hn::Neg(k), none = hn::Zero(D());
  add_lanes(turn0(row0[0], row1[0]), turn0(row0[1], row1[1]), turn0(m.vv[2], m.vv[4]),
            hn::Mul(minus, sums[0]), own);
  add_lanes(turn1(row0[1], row1[1]), turn1(m.vv[2], m.vv[4]), hn::Mul(minus, sums[1]), m.vv[5], own + 4);
  add_lanes(hn::Mul(minus, m.v[2]), hn::Mul(hn::Mul(k, k), m.w), turn0(m.sv[0], m.sv[1]),
            turn1(m.sv[0], m.sv[1]), own + 8);
  add_lanes(m.sv[2], hn::Mul(minus, m.s), turn0(m.rv[0], m.rv[1]), turn1(m.rv[0], m.rv[1]), own + 12);
  add_lanes(m.rv[2], hn::Mul(minus, m.r), none, none, own + 16);
}

/// Inverse square roots of the pivots on the diagonal, the rest of L below, y = L^-1 g.
template <bool kOffset>
HWY_INLINE void factorise(const Normal& normal, double unobserved, V L[4][4], V* y) {
  const D d;
  constexpr int n = kOffset ? 4 : 3;
  const V one = hn::Set(d, 1.0);
  V largest = normal.A[0][0];
  for (int p = 1; p < n; ++p) largest = hn::Max(largest, normal.A[p][p]);
  // A direction that nothing observes (heading of a lone antenna) is held: it couples to nothing.
  const V floor = hn::Mul(hn::Set(d, unobserved), hn::Add(one, largest));
  for (int p = 0; p < n; ++p) {
    V pivot = hn::Add(normal.A[p][p], floor);
    for (int m = 0; m < p; ++m) pivot = hn::NegMulAdd(L[p][m], L[p][m], pivot);
    pivot = hn::IfThenElse(hn::Gt(pivot, hn::Mul(hn::Set(d, 0.5), floor)), pivot,
                           hn::Mul(hn::Set(d, 100.0), floor));
    const V inverse = hn::Div(one, hn::Sqrt(pivot));
    L[p][p] = inverse;
    V v = normal.g[p];
    for (int m = 0; m < p; ++m) v = hn::NegMulAdd(L[p][m], y[m], v);
    y[p] = hn::Mul(v, inverse);
    for (int q = p + 1; q < n; ++q) {
      V below = normal.A[q][p];
      for (int m = 0; m < p; ++m) below = hn::NegMulAdd(L[q][m], L[p][m], below);
      L[q][p] = hn::Mul(below, inverse);
    }
  }
}

/// Some rows of a block of taken += Y'Y, for the rows of Y that wait.
template <std::size_t kHeld>
HWY_INLINE void take_block(const Lanes* left, const Lanes* right, std::size_t stride, std::size_t waiting,
                           std::size_t part, double* block) {
  constexpr std::size_t kColumns = StopSums::kBlock;
  V sum[kHeld][kColumns];
  for (auto& row : sum)
    for (V& v : row) v = hn::Zero(D());
  for (std::size_t m = 0; m < waiting; ++m) {
    V r[kColumns];
    for (std::size_t k = 0; k < kColumns; ++k) r[k] = load(right[k * stride + m], part);
    for (std::size_t p = 0; p < kHeld; ++p) {
      const V l = load(left[p * stride + m], part);
      for (std::size_t q = 0; q < kColumns; ++q) sum[p][q] = hn::MulAdd(l, r[q], sum[p][q]);
    }
  }
  for (std::size_t p = 0; p < kHeld; ++p)
    add_lanes(sum[p][0], sum[p][1], sum[p][2], sum[p][3], block + p * kColumns);
}

void take_in_lanes(StopSums& sums) {
  // As many rows as the registers hold: 32 of them with AVX-512, else 16.
  constexpr std::size_t kHeld = HWY_TARGET <= HWY_AVX3 ? 4 : 2, kBlock = StopSums::kBlock;
  const std::size_t states = sums.has_offset ? 4 : 3, stride = StopSums::kPacksAtOnce * states,
                    waiting = sums.waiting * states;
  const std::size_t active = sums.active.size();
  const Lanes* rows = sums.rows.data();
  for (std::size_t part = 0; part < kLanes; part += hn::Lanes(D())) {
    double* block = sums.taken.data();
    for (std::size_t i = 0; i < active; i += kBlock)
      for (std::size_t j = i; j < active; j += kBlock, block += kBlock * kBlock)
        for (std::size_t r = 0; r < kBlock; r += kHeld)
          take_block<kHeld>(rows + (i + r) * stride, rows + j * stride, stride, waiting, part,
                            block + r * kBlock);
  }
}

template <bool kOffset, bool kRobust>
HWY_INLINE void reduce_part(const StopTables tables, const StopPack pack, const StopStates& states,
                            const StopLayout& layout, double unobserved, std::size_t part, StopSums& sums) {
  const D d;
  // Copies, as a vector may be stored anywhere: what is reached through a reference would be read again after
  // every store.
  const bool receivers_free = layout.receivers_free;
  const std::size_t receivers = layout.receivers, columns = layout.columns() + 1,
                    speed_column = layout.speed(), receiver_column = layout.of_receiver(0);
  double *const beacon_sums = sums.beacon.data(), *const receiver_sums = sums.receiver.data(),
                *const pair_sums = sums.pair.data();
  constexpr int n = kOffset ? 4 : 3;
  const V zero = hn::Zero(d);
  const Constants constants(tables);
  View view;
  for (int i = 0; i < 4; ++i) view.state[i] = load(states.value[i], part);
  view.turn();
  Lanes* coupling = sums.coupling.data();
  for (std::size_t c = 0; c < 4 * columns; ++c) store(zero, coupling[c], part);
  Normal normal;
  normal.clear();
  V speed_curvature = zero, speed_gradient = zero, by_speed_of_state[4] = {zero, zero, zero, zero};
  for (std::size_t slot = 0; slot < pack.slots;) {
    const std::size_t receiver = pack.slot[slot].receiver;
    const Antenna antenna(tables, receiver, view, constants);
    Moments all;
    all.clear();
    for (; slot < pack.slots && pack.slot[slot].receiver == receiver; ++slot) {
      const std::size_t beacon = pack.slot[slot].beacon;
      const Sight s = look<kRobust>(tables, pack, slot, part, antenna, constants);
      const V by_speed = by_speed_of(s, constants);
      const Moments m = moments_of(s, by_speed);
      speed_curvature = hn::MulAdd(m.s, by_speed, speed_curvature);
      speed_gradient = hn::MulAdd(m.r, by_speed, speed_gradient);
      all.add(m);
      m.add_to_sums(beacon_sums + StopSums::kMoments * beacon);
      couple_beacon<kOffset>(m, antenna, constants, part, coupling + 16 * beacon);
      if (receivers_free)
        add_pair(m, s, view, constants, pair_sums + StopSums::kPair * (beacon * receivers + receiver));
    }
    add_receiver<kOffset>(antenna, constants, all.vv[0], all.vv[1], all.vv[3], all.rv[0], all.rv[1], all.v[0],
                          all.v[1], all.w, all.r, normal);
    by_speed_of_state[0] = hn::Add(by_speed_of_state[0], all.sv[0]);
    by_speed_of_state[1] = hn::Add(by_speed_of_state[1], all.sv[1]);
    by_speed_of_state[2] =
        hn::Add(by_speed_of_state[2], hn::NegMulAdd(antenna.ry, all.sv[0], hn::Mul(antenna.rx, all.sv[1])));
    if constexpr (kOffset)
      by_speed_of_state[3] = hn::MulAdd(constants.by_offset, all.s, by_speed_of_state[3]);
    if (receivers_free)
      finish_receiver<kOffset>(all, antenna, view, constants, part,
                               coupling + 4 * (receiver_column + 4 * receiver),
                               receiver_sums + StopSums::kReceiver * receiver);
  }
  sums.speed_curvature += hn::GetLane(hn::SumOfLanes(d, speed_curvature));
  sums.speed_gradient += hn::GetLane(hn::SumOfLanes(d, speed_gradient));
  for (int p = 0; p < n; ++p)
    store(by_speed_of_state[p], coupling[4 * speed_column + static_cast<std::size_t>(p)], part);

  if (pack.poses != nullptr) add_poses(pack, part, view, normal);
  V L[4][4], y[4];
  factorise<kOffset>(normal, unobserved, L, y);
  const std::size_t count = sums.active.size();
  const std::size_t* const active = sums.active.data();
  Lanes* rows = sums.rows.data() + sums.waiting * n;
  double* const taken_gradient = sums.taken_gradient.data();
  for (std::size_t a = 0; a < count; a += 4) {
    V gradient[4];
    for (std::size_t i = 0; i < 4; ++i, rows += StopSums::kPacksAtOnce * n) {
      const Lanes* G = coupling + 4 * active[a + i];
      V Y[4];
      gradient[i] = zero;
      for (int p = 0; p < n; ++p) {
        V v = load(G[p], part);
        for (int m = 0; m < p; ++m) v = hn::NegMulAdd(L[p][m], Y[m], v);
        Y[p] = hn::Mul(v, L[p][p]);
        store(Y[p], rows[p], part);
        gradient[i] = hn::MulAdd(y[p], Y[p], gradient[i]);
      }
    }
    add_lanes(gradient[0], gradient[1], gradient[2], gradient[3], taken_gradient + a);
  }
}

void reduce_stops_in_lanes(const StopTables& tables, const StopPack& pack, const StopStates& states,
                           const StopLayout& layout, double unobserved, StopSums& sums) {
  const bool robust = tables.late_scale > 0 && tables.early_scale > 0;
  for (std::size_t part = 0; part < kLanes; part += hn::Lanes(D())) {
    if (tables.has_offset) {
      robust ? reduce_part<true, true>(tables, pack, states, layout, unobserved, part, sums)
             : reduce_part<true, false>(tables, pack, states, layout, unobserved, part, sums);
    } else {
      robust ? reduce_part<false, true>(tables, pack, states, layout, unobserved, part, sums)
             : reduce_part<false, false>(tables, pack, states, layout, unobserved, part, sums);
    }
  }
}

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace octant::calib
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::calib {

HWY_EXPORT(settle_stops_in_lanes);
HWY_EXPORT(reduce_stops_in_lanes);
HWY_EXPORT(take_in_lanes);
HWY_EXPORT(target_name);

void settle_stops(const StopTables& tables, const StopPack& pack, StopStates& states, StopOutcome& outcome) {
  HWY_DYNAMIC_DISPATCH(settle_stops_in_lanes)(tables, pack, states, outcome);
}

namespace {

void take_waiting(StopSums& sums) {
  HWY_DYNAMIC_DISPATCH(take_in_lanes)(sums);
  sums.waiting = 0;
}

}  // namespace

void reduce_stops(const StopTables& tables, const StopPack& pack, const StopStates& states,
                  const StopLayout& layout, double unobserved, StopSums& sums) {
  HWY_DYNAMIC_DISPATCH(reduce_stops_in_lanes)(tables, pack, states, layout, unobserved, sums);
  if (++sums.waiting == StopSums::kPacksAtOnce) take_waiting(sums);
}

const char* stop_kernel_target() { return HWY_DYNAMIC_DISPATCH(target_name)(); }

void StopSums::clear(const StopLayout& layout, bool offset) {
  const std::size_t receivers = layout.receivers_free ? layout.receivers : 0;
  has_offset = offset;
  active = layout.active;
  while (active.size() % kBlock != 0) active.push_back(layout.columns());
  beacon.assign(kMoments * layout.beacons, 0.0);
  receiver.assign(kReceiver * receivers, 0.0);
  pair.assign(kPair * layout.beacons * receivers, 0.0);
  const std::size_t side = active.size() / kBlock;
  taken.assign(side * (side + 1) / 2 * kBlock * kBlock, 0.0);
  taken_gradient.assign(active.size(), 0.0);
  speed_curvature = speed_gradient = 0.0;
  coupling.resize(4 * (layout.columns() + 1));
  rows.resize(active.size() * kPacksAtOnce * (offset ? 4 : 3));
  waiting = 0;
}

void StopSums::finish(const StopLayout& layout, double sigma_s, std::vector<double>& H,
                      std::vector<double>& gradient) {
  if (waiting > 0) take_waiting(*this);
  const std::size_t columns = layout.columns(), at_speed = layout.speed();
  const double k = 1.0 / sigma_s;
  H.assign(columns * columns, 0.0);
  gradient.assign(columns, 0.0);
  const auto element = [&](std::size_t i, std::size_t j) -> double& { return H[i * columns + j]; };
  for (std::size_t b = 0; b < layout.beacons; ++b) {  // derivatives -(v, k)
    const double* m = beacon.data() + kMoments * b;
    const std::size_t at = 4 * b;
    for (std::size_t i = 0, e = 4; i < 3; ++i) {
      for (std::size_t j = i; j < 3; ++j, ++e) element(at + i, at + j) = m[e];
      element(at + i, at + 3) = k * m[1 + i];
      element(at + i, at_speed) = -m[12 + i];
      gradient[at + i] = -m[16 + i];
    }
    element(at + 3, at + 3) = k * k * m[0];
    element(at + 3, at_speed) = -k * m[10];
    gradient[at + 3] = -k * m[11];
  }
  for (std::size_t r = 0; layout.receivers_free && r < layout.receivers; ++r) {
    const double* m = receiver.data() + kReceiver * r;
    const std::size_t at = layout.of_receiver(r);
    for (std::size_t i = 0, e = 0; i < 4; ++i) {
      for (std::size_t j = i; j < 4; ++j, ++e) element(at + i, at + j) = m[e];
      element(at + i, at_speed) = m[10 + i];
      gradient[at + i] = m[14 + i];
    }
    for (std::size_t b = 0; b < layout.beacons; ++b)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
          element(4 * b + i, at + j) = pair[kPair * (b * layout.receivers + r) + 4 * i + j];
  }
  element(at_speed, at_speed) = speed_curvature;
  gradient[at_speed] = speed_gradient;
  const std::size_t count = layout.active.size();
  for (std::size_t i = 0; i < count; ++i) gradient[active[i]] -= taken_gradient[i];
  const double* e = taken.data();
  for (std::size_t i = 0; i < count; i += kBlock)
    for (std::size_t j = i; j < count; j += kBlock)
      for (std::size_t r = i; r < i + kBlock; ++r)
        for (std::size_t c = j; c < j + kBlock; ++c, ++e)
          if (r < count && c < count && r <= c) element(active[r], active[c]) -= *e;
}

}  // namespace octant::calib
#endif
