// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/lanes/stop_solve.h"

#include "models/support/observed.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calib/lanes/stop_solve.cc"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set
#include <hwy/highway.h>

#include "calib/lanes/stop_path-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octant::calib {
namespace HWY_NAMESPACE {

/// Steps and limits of `solve_states` in models/trajectory/solve_states.cc.
constexpr int kMaxIterations = 30;
constexpr double kAtRest = 1e-13;
/// With plain squares, a step that gains less than this fraction of the cost is accepted without another
/// evaluation: the remaining gain is smaller by the square of residual over distance.
constexpr double kLastStep = 1e-6;

template <bool kOffset, bool kRobust>
HWY_INLINE void build(const StopTables& tables, const StopPack& pack, std::size_t part, const View& view,
                      const Constants& constants, StopNormal& out) {
  out.clear();
  for (std::size_t slot = 0; slot < pack.slots;) {
    const std::size_t receiver = pack.slot[slot].receiver;
    const Antenna antenna(tables, receiver, view, constants);
    V v00 = 0.0, v01 = 0.0, v11 = 0.0, r0 = 0.0, r1 = 0.0, w0 = 0.0, w1 = 0.0, w = 0.0, r = 0.0;
    for (; slot < pack.slots && pack.slot[slot].receiver == receiver; ++slot) {
      const PathSight s = sight_along<kRobust>(tables, pack, slot, part, antenna, constants);
      if constexpr (kRobust)
        out.cost += s.rho;
      else
        out.cost += s.residual * s.residual;
      const V wv0 = s.weight * s.v[0], wv1 = s.weight * s.v[1];
      v00 += wv0 * s.v[0];
      v01 += wv0 * s.v[1];
      v11 += wv1 * s.v[1];
      r0 += wv0 * s.residual;
      r1 += wv1 * s.residual;
      if constexpr (kOffset) {
        w0 += wv0;
        w1 += wv1;
        w += s.weight;
        r += s.weight * s.residual;
      }
    }
    add_receiver<kOffset>(antenna, constants, {v00, v01, v11, r0, r1, w0, w1, w, r}, out);
  }
  if (pack.poses != nullptr) add_poses(pack, part, view, out);
  out.cost = out.cost * 0.5;
}

/// Diagonal of the heading: Gauss-Newton plus the curvature of the ranges. A lever arm is hardly longer than
/// the residuals while the beacons are inaccurate, and steps without the curvature then converge slowly.
/// Negative curvature is limited to half of the diagonal, and is ignored if it would change the sign: such a
/// state is outside the range of Newton's method. Curvature above the diagonal only shortens steps and counts
/// in `stiff` lanes; in the others, longer steps can leave local minima of the loss.
HWY_INLINE V bent(V diagonal, V bend, Mask stiff) {
  const Mask counts = (bend >= -diagonal) & (stiff | (bend <= diagonal));
  return select(counts, max(diagonal + bend, V(0.5 * diagonal)), diagonal);
}

/// Solves (A + lambda diag A + floor) s = -g, A with the heading's bend.
/// @return lanes where that is positive definite
template <bool kOffset>
HWY_INLINE Mask solve(const StopNormal& normal, V lambda, Mask stiff, V* step) {
  constexpr int n = kOffset ? 4 : 3;
  const V one = 1.0;
  V largest = normal.A[0][0];
  for (int p = 1; p < n; ++p) largest = max(largest, normal.A[p][p]);
  const V floor = kStepFloor * (one + largest);
  const auto damped = [&](int p, int q) -> V {
    if (p != q) return normal.A[p][q];
    const V diagonal = p == 2 ? bent(normal.A[p][p], normal.bend, stiff) : normal.A[p][p];
    return lambda * diagonal + diagonal + floor;
  };
  Mask sound = one == one;
  SmallCholesky<n, V> factor;
  factor.factor(damped, [&sound](V pivot) -> V {
    sound = sound & (pivot > 0.0);
    return max(pivot, 1e-300);
  });
  for (int p = 0; p < n; ++p) step[p] = -normal.g[p];
  factor.forward(step);
  factor.backward(step);
  return sound;
}

/// Damping after a step: a tenth after an improvement, down to almost zero; ten times as much otherwise.
HWY_INLINE V next_damping(V lambda, Mask better) {
  const V calmer = select(lambda < 1e-7, 1e-8, lambda * 0.1);
  return select(better, calmer, max(lambda * 10.0, 1e-5));
}

template <bool kOffset, bool kRobust>
HWY_INLINE void solve_part(const StopTables tables, const StopPack pack, std::size_t part, StopStates& states,
                           StopOutcome& outcome) {
  constexpr int n = kOffset ? 4 : 3;
  const Constants constants(tables);
  View view(states, part);
  StopNormal now, trial;
  build<kOffset, kRobust>(tables, pack, part, view, constants, now);
  V lambda = 1e-8, rest = 0.0;  // rest: 1 if there is no gain left
  const V one = 1.0;
  // Squares have one minimum nearby, and a measured heading is near its own.
  Mask stiff = one == V(kRobust ? 0.0 : 1.0);
  if (pack.poses != nullptr) stiff = stiff | (load(pack.poses->weight[2], part) > 0.0);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    V step[4];
    const Mask sound = solve<kOffset>(now, lambda, stiff, step);
    V gain = 0.0;  // half the Newton decrement: decrease of a quadratic cost
    for (int p = 0; p < n; ++p) gain -= now.g[p] * step[p];
    gain = 0.5 * gain;
    const Mask moving = rest < one;
    rest = select(sound & (gain <= kAtRest * (one + now.cost)), one, rest);
    if constexpr (!kRobust) {
      const Mask last = moving & (sound & ((gain <= kLastStep * (one + now.cost)) & (lambda < 1e-7)));
      for (int p = 0; p < n; ++p) view.state[p] = select(last, view.state[p] + step[p], view.state[p]);
      now.cost = select(last, now.cost - gain, now.cost);
      rest = select(last, one, rest);
    }
    if (all(rest == one)) break;
    View moved = view;
    for (int p = 0; p < n; ++p) moved.state[p] = select(rest == one, view.state[p], view.state[p] + step[p]);
    moved.turn();
    build<kOffset, kRobust>(tables, pack, part, moved, constants, trial);
    const Mask better = (rest < one) & (sound & (trial.cost <= now.cost * (1.0 + 1e-14)));
    // Neither better nor significantly improvable: converged to rounding.
    rest = select(but_not(gain < 1e-12 * (one + now.cost), better), one, rest);
    for (int p = 0; p < 4; ++p) view.state[p] = select(better, moved.state[p], view.state[p]);
    now.assign_where<n>(better, trial);
    lambda = next_damping(lambda, better);
  }
  for (int i = 0; i < 4; ++i) store(view.state[i], states.value[i], part);
  store(now.cost, outcome.cost, part);
  store(only(abs(now.cost) < 1e300, rest), outcome.converged, part);
}

void solve_stops_in_lanes(const StopTables& tables, const StopPack& pack, StopStates& states,
                          StopOutcome& outcome) {
  const bool robust = tables.late_scale > 0 && tables.early_scale > 0;
  for (std::size_t part = 0; part < kLanes; part += lanes_at_once()) {
    if (tables.has_offset) {
      robust ? solve_part<true, true>(tables, pack, part, states, outcome)
             : solve_part<true, false>(tables, pack, part, states, outcome);
    } else {
      robust ? solve_part<false, true>(tables, pack, part, states, outcome)
             : solve_part<false, false>(tables, pack, part, states, outcome);
    }
  }
}

const char* solve_target() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace octant::calib
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::calib {

HWY_EXPORT(solve_stops_in_lanes);
HWY_EXPORT(solve_target);

void solve_stops(const StopTables& tables, const StopPack& pack, StopStates& states, StopOutcome& outcome) {
  HWY_DYNAMIC_DISPATCH(solve_stops_in_lanes)(tables, pack, states, outcome);
}

const char* stop_kernel_target() { return HWY_DYNAMIC_DISPATCH(solve_target)(); }

}  // namespace octant::calib
#endif
