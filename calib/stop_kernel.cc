// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stop_kernel.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calib/stop_kernel.cc"
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
constexpr double kMinDistanceM = 1e-6;

/// Normal equations of as many epochs as a vector holds, at one state each.
struct Normal {
  V D[10];  ///< upper triangle of 4 x 4: 00 01 02 03 11 12 13 22 23 33
  V g[4];
  V cost;
};

HWY_INLINE V gather(D d, const double* table, hn::Vec<hn::RebindToSigned<D>> index) { return hn::GatherIndex(d, table, index); }

/// Cauchy's loss on either side: rho and its derivative by the square.
template <bool kRobust>
HWY_INLINE void evaluate_loss(D d, V residual, V late2, V early2, V inverse_late2, V inverse_early2, V& rho, V& weight) {
  const V s2 = hn::Mul(residual, residual);
  if constexpr (!kRobust) {
    rho = s2;
    weight = hn::Set(d, 1.0);
  } else {
    const auto late = hn::Gt(residual, hn::Zero(d));
    const V c2 = hn::IfThenElse(late, late2, early2);
    const V t = hn::Mul(s2, hn::IfThenElse(late, inverse_late2, inverse_early2));
    rho = hn::Mul(c2, hn::Log1p(d, t));
    weight = hn::Div(hn::Set(d, 1.0), hn::Add(hn::Set(d, 1.0), t));
  }
}

template <bool kOffset, bool kRobust>
HWY_INLINE void build(D d, const StopTables& tables, const StopLanes& lanes, std::size_t part, const V* state, V cosine, V sine, Normal& out) {
  const hn::RebindToSigned<D> di;
  const hn::Rebind<std::int32_t, D> di32;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0);
  const V k = hn::Set(d, 1.0 / tables.sigma_s);
  const V late2 = hn::Set(d, tables.late_scale * tables.late_scale), early2 = hn::Set(d, tables.early_scale * tables.early_scale);
  const V inverse_late2 = hn::Div(one, late2), inverse_early2 = hn::Div(one, early2);
  const V offset_s = kOffset ? hn::Mul(state[3], hn::Set(d, 1.0 / tables.nominal_speed_mps)) : zero;
  V speed = hn::Set(d, tables.speed_mps);
  for (V& v : out.D) v = zero;
  for (V& v : out.g) v = zero;
  out.cost = zero;
  for (std::size_t slot = 0; slot < lanes.slots; ++slot) {
    const std::size_t at = slot * kLanes + part;
    const auto beacon = hn::PromoteTo(di, hn::LoadU(di32, lanes.beacon + at));
    const auto receiver = hn::PromoteTo(di, hn::LoadU(di32, lanes.receiver + at));
    const auto used = hn::RebindMask(d, hn::Gt(beacon, hn::Set(di, -1)));
    const auto b = hn::ShiftLeft<2>(hn::Max(beacon, hn::Zero(di))), r = hn::ShiftLeft<2>(receiver);
    const V ox = gather(d, tables.receiver, r), oy = gather(d, tables.receiver + 1, r);
    if (lanes.model_speed_mps != nullptr) speed = hn::Add(hn::LoadU(d, lanes.model_speed_mps + at), hn::Set(d, tables.speed_offset_mps));
    const V rx = hn::Sub(hn::Mul(cosine, ox), hn::Mul(sine, oy)), ry = hn::Add(hn::Mul(sine, ox), hn::Mul(cosine, oy));
    const V dx = hn::Sub(hn::Add(state[0], rx), gather(d, tables.beacon, b));
    const V dy = hn::Sub(hn::Add(state[1], ry), gather(d, tables.beacon + 1, b));
    const V dz = hn::Sub(gather(d, tables.receiver + 2, r), gather(d, tables.beacon + 2, b));
    const V distance = hn::Max(hn::Sqrt(hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)))), hn::Set(d, kMinDistanceM));
    const V delay = hn::Add(hn::Add(gather(d, tables.beacon + 3, b), gather(d, tables.receiver + 3, r)), offset_s);
    const V inverse_speed = hn::Div(one, speed);
    const V residual = hn::Mul(k, hn::Sub(hn::Sub(hn::LoadU(d, lanes.tof_s + at), delay), hn::Mul(distance, inverse_speed)));
    V rho, w;
    evaluate_loss<kRobust>(d, residual, late2, early2, inverse_late2, inverse_early2, rho, w);
    w = hn::IfThenElseZero(used, w);
    out.cost = hn::Add(out.cost, hn::IfThenElseZero(used, rho));
    // Derivatives of the residual: -(unit vector) / (c sigma), by the heading along the turned lever arm.
    const V by_range = hn::Neg(hn::Div(hn::Mul(k, inverse_speed), distance));
    V j[4];
    j[0] = hn::Mul(by_range, dx);
    j[1] = hn::Mul(by_range, dy);
    j[2] = hn::Sub(hn::Mul(j[1], rx), hn::Mul(j[0], ry));
    j[3] = kOffset ? hn::Set(d, -1.0 / (tables.sigma_s * tables.nominal_speed_mps)) : zero;
    constexpr int n = kOffset ? 4 : 3;
    for (int p = 0, e = 0; p < 4; ++p)
      for (int q = p; q < 4; ++q, ++e)
        if (p < n && q < n) out.D[e] = hn::MulAdd(hn::Mul(w, j[p]), j[q], out.D[e]);
    const V wr = hn::Mul(w, residual);
    for (int p = 0; p < n; ++p) out.g[p] = hn::MulAdd(wr, j[p], out.g[p]);
  }
  out.cost = hn::Mul(out.cost, hn::Set(d, 0.5));
}

/// Solves (D + lambda diag D + floor) s = -g by Cholesky; lanes where it is not positive definite come out with `sound` off.
template <bool kOffset>
HWY_INLINE void solve(D d, const Normal& normal, V lambda, V* step, hn::Mask<D>& sound) {
  constexpr int n = kOffset ? 4 : 3;
  const V one = hn::Set(d, 1.0);
  V A[4][4], L[4][4];
  for (int p = 0, e = 0; p < 4; ++p)
    for (int q = p; q < 4; ++q, ++e) A[q][p] = normal.D[e];
  V largest = A[0][0];
  for (int p = 1; p < n; ++p) largest = hn::Max(largest, A[p][p]);
  const V floor = hn::Mul(hn::Set(d, 1e-9), hn::Add(one, largest));
  V y[4];
  sound = hn::Eq(one, one);
  for (int p = 0; p < n; ++p) {
    V pivot = hn::Add(hn::MulAdd(lambda, A[p][p], A[p][p]), floor);
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

HWY_INLINE void sine_and_cosine(D d, V heading, V& sine, V& cosine) {
  alignas(64) double angle[kLanes], s[kLanes], c[kLanes];
  hn::Store(heading, d, angle);
  for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
    s[i] = std::sin(angle[i]);
    c[i] = std::cos(angle[i]);
  }
  sine = hn::Load(d, s);
  cosine = hn::Load(d, c);
}

template <bool kOffset, bool kRobust>
HWY_INLINE void settle_part(const StopTables& tables, const StopLanes& lanes, std::size_t part, StopStates& states, StopOutcome& outcome) {
  const D d;
  constexpr int n = kOffset ? 4 : 3;
  V state[4], sine, cosine;
  for (int i = 0; i < 4; ++i) state[i] = hn::Load(d, states.value[i] + part);
  sine_and_cosine(d, state[2], sine, cosine);
  Normal now, trial;
  build<kOffset, kRobust>(d, tables, lanes, part, state, cosine, sine, now);
  V lambda = hn::Set(d, 1e-8), rest = hn::Zero(d);  // rest: 1 where nothing is left to gain
  const V one = hn::Set(d, 1.0);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    V step[4];
    hn::Mask<D> sound;
    solve<kOffset>(d, now, lambda, step, sound);
    V gain = hn::Zero(d);
    for (int p = 0; p < n; ++p) gain = hn::NegMulAdd(now.g[p], step[p], gain);
    gain = hn::Mul(hn::Set(d, 0.5), gain);
    rest = hn::IfThenElse(hn::And(sound, hn::Le(gain, hn::Mul(hn::Set(d, kAtRest), hn::Add(one, now.cost)))), one, rest);
    if (hn::AllTrue(d, hn::Eq(rest, one))) break;
    V moved[4];
    for (int p = 0; p < n; ++p) moved[p] = hn::IfThenElse(hn::Eq(rest, one), state[p], hn::Add(state[p], step[p]));
    if constexpr (!kOffset) moved[3] = state[3];
    V s, c;
    sine_and_cosine(d, moved[2], s, c);
    build<kOffset, kRobust>(d, tables, lanes, part, moved, c, s, trial);
    const auto better = hn::And(sound, hn::Le(trial.cost, hn::Mul(now.cost, hn::Set(d, 1.0 + 1e-14))));
    // Neither better nor much left to gain: at rest to rounding.
    const auto rounding = hn::AndNot(better, hn::Lt(gain, hn::Mul(hn::Set(d, 1e-12), hn::Add(one, now.cost))));
    rest = hn::IfThenElse(rounding, one, rest);
    for (int p = 0; p < 4; ++p) state[p] = hn::IfThenElse(better, moved[p], state[p]);
    for (int e = 0; e < 10; ++e) now.D[e] = hn::IfThenElse(better, trial.D[e], now.D[e]);
    for (int p = 0; p < 4; ++p) now.g[p] = hn::IfThenElse(better, trial.g[p], now.g[p]);
    now.cost = hn::IfThenElse(better, trial.cost, now.cost);
    const V calmer = hn::IfThenElse(hn::Lt(lambda, hn::Set(d, 1e-7)), hn::Set(d, 1e-8), hn::Mul(lambda, hn::Set(d, 0.1)));
    lambda = hn::IfThenElse(better, calmer, hn::Max(hn::Mul(lambda, hn::Set(d, 10.0)), hn::Set(d, 1e-5)));
  }
  for (int i = 0; i < 4; ++i) hn::Store(state[i], d, states.value[i] + part);
  hn::Store(now.cost, d, outcome.cost + part);
  const auto finite = hn::Lt(hn::Abs(now.cost), hn::Set(d, 1e300));
  hn::Store(hn::IfThenElseZero(finite, rest), d, outcome.converged + part);
}

void settle_stops_in_lanes(const StopTables& tables, const StopLanes& lanes, StopStates& states, StopOutcome& outcome) {
  const bool robust = tables.late_scale > 0 && tables.early_scale > 0;
  for (std::size_t part = 0; part < kLanes; part += hn::Lanes(D())) {
    if (tables.has_offset) {
      robust ? settle_part<true, true>(tables, lanes, part, states, outcome) : settle_part<true, false>(tables, lanes, part, states, outcome);
    } else {
      robust ? settle_part<false, true>(tables, lanes, part, states, outcome) : settle_part<false, false>(tables, lanes, part, states, outcome);
    }
  }
}

/// row[i] += factor * other[i]
HWY_INLINE void add_multiple(double factor, const double* other, std::size_t count, double* row) {
  const D d;
  const V f = hn::Set(d, factor);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) hn::StoreU(hn::MulAdd(f, hn::LoadU(d, other + i), hn::LoadU(d, row + i)), d, row + i);
}

int reduce_stop_in_lanes(const StopTables& tables, const StopEpoch& epoch, const StopLayout& layout, double unobserved, double* H, double* gradient,
                         double* rows) {
  using D4 = hn::CappedTag<double, 4>;
  const D4 d4;
  const std::size_t width = hn::Lanes(d4), stride = layout.stride(), speed_column = layout.speed();
  const std::size_t receivers_at = 4 * layout.beacons;
  const int n = tables.has_offset ? 4 : 3;
  double* G[4];
  for (int p = 0; p < 4; ++p) G[p] = rows + static_cast<std::size_t>(p < n ? p : 0) * stride;
  std::fill(rows, rows + static_cast<std::size_t>(n) * stride, 0.0);
  double A[4][4] = {}, g[4] = {};
  const double sine = std::sin(epoch.heading_rad), cosine = std::cos(epoch.heading_rad), k = 1.0 / tables.sigma_s;
  const double offset_s = tables.has_offset ? epoch.offset_m / tables.nominal_speed_mps : 0.0;
  const StopLanes& lanes = *epoch.lanes;
  for (std::size_t slot = 0; slot < lanes.slots; ++slot) {
    const std::size_t at = slot * kLanes + epoch.lane;
    if (lanes.beacon[at] < 0) break;
    const double* b = tables.beacon + std::ptrdiff_t{4} * lanes.beacon[at];
    const double* o = tables.receiver + std::ptrdiff_t{4} * lanes.receiver[at];
    const double speed = lanes.model_speed_mps != nullptr ? lanes.model_speed_mps[at] + tables.speed_offset_mps : tables.speed_mps;
    const double rx = cosine * o[0] - sine * o[1], ry = sine * o[0] + cosine * o[1];
    const double dx = epoch.x_m + rx - b[0], dy = epoch.y_m + ry - b[1], dz = o[2] - b[2];
    const double distance = std::max(std::sqrt(dx * dx + dy * dy + dz * dz), kMinDistanceM);
    const double residual = k * (lanes.tof_s[at] - b[3] - o[3] - offset_s - distance / speed);
    double w = 1.0;
    if (const double scale = residual > 0 ? tables.late_scale : tables.early_scale; scale > 0) w = 1.0 / (1.0 + residual * residual / (scale * scale));
    const double by_range = -k / (speed * distance);
    const double j[4] = {by_range * dx, by_range * dy, by_range * (dy * rx - dx * ry), -k / tables.nominal_speed_mps};
    alignas(32) const double by_beacon[4] = {-j[0], -j[1], -by_range * dz, -k};
    // In the vehicle frame: the unit vector turned back.
    alignas(32) const double by_receiver[4] = {cosine * j[0] + sine * j[1], cosine * j[1] - sine * j[0], by_range * dz, -k};
    const double by_speed = k * distance / (speed * speed);
    const std::size_t cb = 4 * static_cast<std::size_t>(epoch.local_beacon[at]);
    const std::size_t cr = receivers_at + 4 * static_cast<std::size_t>(epoch.local_receiver[at]);
    for (int p = 0; p < n; ++p) {
      const double wj = w * j[p];
      for (int q = p; q < n; ++q) A[p][q] += wj * j[q];
      g[p] += wj * residual;
      G[p][speed_column] += wj * by_speed;
    }
    for (std::size_t i = 0; i < 4; i += width) {
      const auto jb = hn::LoadU(d4, by_beacon + i), jr = hn::LoadU(d4, by_receiver + i);
      for (int p = 0; p < n; ++p) {
        const auto wj = hn::Set(d4, w * j[p]);
        hn::StoreU(hn::MulAdd(wj, jb, hn::LoadU(d4, G[p] + cb + i)), d4, G[p] + cb + i);
        hn::StoreU(hn::MulAdd(wj, jr, hn::LoadU(d4, G[p] + cr + i)), d4, G[p] + cr + i);
      }
      const auto wr = hn::Set(d4, w * residual);
      hn::StoreU(hn::MulAdd(wr, jb, hn::LoadU(d4, gradient + cb + i)), d4, gradient + cb + i);
      hn::StoreU(hn::MulAdd(wr, jr, hn::LoadU(d4, gradient + cr + i)), d4, gradient + cr + i);
      for (std::size_t a = 0; a < 4; ++a) {
        double* row_b = H + (cb + a) * stride;
        double* row_r = H + (cr + a) * stride;
        const auto wb = hn::Set(d4, w * by_beacon[a]), wo = hn::Set(d4, w * by_receiver[a]);
        hn::StoreU(hn::MulAdd(wb, jb, hn::LoadU(d4, row_b + cb + i)), d4, row_b + cb + i);
        hn::StoreU(hn::MulAdd(wb, jr, hn::LoadU(d4, row_b + cr + i)), d4, row_b + cr + i);
        hn::StoreU(hn::MulAdd(wo, jr, hn::LoadU(d4, row_r + cr + i)), d4, row_r + cr + i);
      }
    }
    for (std::size_t a = 0; a < 4; ++a) {
      H[(cb + a) * stride + speed_column] += w * by_beacon[a] * by_speed;
      H[(cr + a) * stride + speed_column] += w * by_receiver[a] * by_speed;
    }
    H[speed_column * stride + speed_column] += w * by_speed * by_speed;
    gradient[speed_column] += w * residual * by_speed;
  }
  // A direction that nothing observes (heading of a lone antenna) is held: it couples to nothing.
  double largest = 0.0;
  for (int p = 0; p < n; ++p) largest = std::max(largest, A[p][p]);
  const double floor = unobserved * (1.0 + largest);
  double y[4];
  for (int p = 0; p < n; ++p) {
    double pivot = A[p][p] + floor;
    if (!(pivot > 0.5 * floor)) pivot = 100 * floor;
    const double inverse = 1.0 / std::sqrt(pivot);
    for (int q = p; q < n; ++q) A[p][q] *= inverse;  // row of L'
    y[p] = g[p] * inverse;
    const D d;
    const V scale = hn::Set(d, inverse);
    for (std::size_t i = 0; i < stride; i += hn::Lanes(d)) hn::StoreU(hn::Mul(scale, hn::LoadU(d, G[p] + i)), d, G[p] + i);
    for (int q = p + 1; q < n; ++q) {
      for (int m = q; m < n; ++m) A[q][m] -= A[p][q] * A[p][m];
      g[q] -= A[p][q] * y[p];
      add_multiple(-A[p][q], G[p], stride, G[q]);
    }
  }
  for (int p = 0; p < n; ++p) add_multiple(-y[p], G[p], stride, gradient);
  return n;
}

/// Rows [row, row + 4) of H, columns [at, at + vectors of kWide lanes).
template <std::size_t kWide>
HWY_INLINE void take_away_block(const double* Y, std::size_t count, std::size_t stride, std::size_t row, std::size_t at, double* H) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  V sum[4][kWide];
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t v = 0; v < kWide; ++v) sum[r][v] = hn::LoadU(d, H + (row + r) * stride + at + v * lanes);
  for (std::size_t k = 0; k < count; ++k) {
    const double* y = Y + k * stride;
    V other[kWide];
    for (std::size_t v = 0; v < kWide; ++v) other[v] = hn::LoadU(d, y + at + v * lanes);
    for (std::size_t r = 0; r < 4; ++r) {
      const V factor = hn::Set(d, y[row + r]);
      for (std::size_t v = 0; v < kWide; ++v) sum[r][v] = hn::NegMulAdd(factor, other[v], sum[r][v]);
    }
  }
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t v = 0; v < kWide; ++v) hn::StoreU(sum[r][v], d, H + (row + r) * stride + at + v * lanes);
}

void take_away_in_lanes(const double* Y, std::size_t count, std::size_t stride, double* H) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t row = 0; row < stride; row += 4) {
    std::size_t at = row / kLanes * kLanes;
    for (; at + 2 * lanes <= stride; at += 2 * lanes) take_away_block<2>(Y, count, stride, row, at, H);
    for (; at < stride; at += lanes) take_away_block<1>(Y, count, stride, row, at, H);
  }
}

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace octant::calib
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::calib {

HWY_EXPORT(settle_stops_in_lanes);
HWY_EXPORT(reduce_stop_in_lanes);
HWY_EXPORT(take_away_in_lanes);
HWY_EXPORT(target_name);

void settle_stops(const StopTables& tables, const StopLanes& lanes, StopStates& states, StopOutcome& outcome) {
  HWY_DYNAMIC_DISPATCH(settle_stops_in_lanes)(tables, lanes, states, outcome);
}

int reduce_stop(const StopTables& tables, const StopEpoch& epoch, const StopLayout& layout, double unobserved, double* H, double* gradient,
                double* rows) {
  return HWY_DYNAMIC_DISPATCH(reduce_stop_in_lanes)(tables, epoch, layout, unobserved, H, gradient, rows);
}

void take_away(const double* Y, std::size_t count, std::size_t stride, double* H) {
  HWY_DYNAMIC_DISPATCH(take_away_in_lanes)(Y, count, stride, H);
}

const char* stop_kernel_target() { return HWY_DYNAMIC_DISPATCH(target_name)(); }

}  // namespace octant::calib
#endif
