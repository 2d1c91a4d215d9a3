// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/lanes/stop_reduction.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calib/lanes/stop_reduction.cc"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set
#include <hwy/highway.h>

#include "calib/lanes/stop_path-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octant::calib {
namespace HWY_NAMESPACE {

/// Derivative of a residual by the speed of the medium.
HWY_INLINE V by_speed_of(const PathSight& s, const Constants& constants) {
  return constants.k * s.distance * (s.inverse_speed * s.inverse_speed);
}

/// Moments of some paths, in the order of StopSums::beacon.
struct Moments {
  V w, v[3], vv[6], s, sv[3], r, rv[3];
  HWY_INLINE void clear() {
    w = s = r = 0.0;
    for (int i = 0; i < 3; ++i) v[i] = sv[i] = rv[i] = 0.0;
    for (V& each : vv) each = 0.0;
  }
  HWY_INLINE void add(const Moments& m) {
    w += m.w;
    s += m.s;
    r += m.r;
    for (int i = 0; i < 3; ++i) {
      v[i] += m.v[i];
      sv[i] += m.sv[i];
      rv[i] += m.rv[i];
    }
    for (int i = 0; i < 6; ++i) vv[i] += m.vv[i];
  }
  HWY_INLINE void add_to_sums(double* sums) const {
    const V nothing = 0.0;
    add_lanes(w, v[0], v[1], v[2], sums);
    add_lanes(vv[0], vv[1], vv[2], vv[3], sums + 4);
    add_lanes(vv[4], vv[5], s, r, sums + 8);
    add_lanes(sv[0], sv[1], sv[2], nothing, sums + 12);
    add_lanes(rv[0], rv[1], rv[2], nothing, sums + 16);
  }
};

HWY_INLINE Moments moments_of(const PathSight& s, V by_speed) {
  Moments m;
  m.w = s.weight;
  m.s = s.weight * by_speed;
  m.r = s.weight * s.residual;
  for (int i = 0; i < 3; ++i) {
    m.v[i] = s.weight * s.v[i];
    m.sv[i] = m.s * s.v[i];
    m.rv[i] = m.r * s.v[i];
  }
  for (int i = 0, e = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j, ++e) m.vv[e] = m.v[i] * s.v[j];
  return m;
}

/// Couples a path to its beacon, whose derivatives are -(v, k).
template <bool kOffset>
HWY_INLINE void couple_beacon(const Moments& m, const Antenna& a, const Constants& constants,
                              std::size_t part, Lanes* coupling) {
  const V k = constants.k;
  const V row0[4] = {m.vv[0], m.vv[1], m.vv[2], k * m.v[0]},
          row1[4] = {m.vv[1], m.vv[3], m.vv[4], k * m.v[1]};
  for (std::size_t c = 0; c < 4; ++c) {
    Lanes* G = coupling + 4 * c;
    store(load(G[0], part) - row0[c], G[0], part);
    store(load(G[1], part) - row1[c], G[1], part);
    store(load(G[2], part) - a.rx * row1[c] + a.ry * row0[c], G[2], part);
    if constexpr (kOffset) {
      const V last = c < 3 ? m.v[c] : V(k * m.w);
      store(load(G[3], part) - constants.by_offset * last, G[3], part);
    }
  }
}

/// A vector of the map in the vehicle's frame.
struct IntoVehicle {
  V c, s;
  HWY_INLINE V x(V map_x, V map_y) const { return c * map_x + s * map_y; }
  HWY_INLINE V y(V map_x, V map_y) const { return c * map_y - s * map_x; }
};

/// Products of the derivatives by beacon, -(v, k), and by receiver, (R'v, -k).
HWY_INLINE void add_pair(const Moments& m, const PathSight& s, const View& view, const Constants& constants,
                         double* pair) {
  const IntoVehicle R{view.cosine, view.sine};
  const V by_receiver[3] = {R.x(s.v[0], s.v[1]), R.y(s.v[0], s.v[1]), s.v[2]};
  const V left[4] = {-m.v[0], -m.v[1], -m.v[2], -(constants.k * m.w)};
  const V last = -constants.k;
  for (std::size_t i = 0; i < 4; ++i)
    add_lanes(left[i] * by_receiver[0], left[i] * by_receiver[1], left[i] * by_receiver[2], left[i] * last,
              pair + 4 * i);
}

/// A receiver's own elements and its coupling to the state, from the moments of its paths. Derivatives by the
/// receiver: (R'v, -k).
template <bool kOffset>
HWY_INLINE void finish_receiver(const Moments& m, const Antenna& a, const View& view,
                                const Constants& constants, std::size_t part, Lanes* coupling, double* own) {
  const IntoVehicle R{view.cosine, view.sine};
  const V k = constants.k;
  const V row0[4] = {R.x(m.vv[0], m.vv[1]), R.y(m.vv[0], m.vv[1]), m.vv[2], -(k * m.v[0])};
  const V row1[4] = {R.x(m.vv[1], m.vv[3]), R.y(m.vv[1], m.vv[3]), m.vv[4], -(k * m.v[1])};
  const V sums[4] = {R.x(m.v[0], m.v[1]), R.y(m.v[0], m.v[1]), m.v[2], -(k * m.w)};
  for (std::size_t i = 0; i < 4; ++i) {
    Lanes* G = coupling + 4 * i;
    store(row0[i], G[0], part);
    store(row1[i], G[1], part);
    store(a.rx * row1[i] - a.ry * row0[i], G[2], part);
    if constexpr (kOffset) store(constants.by_offset * sums[i], G[3], part);
  }
  const V minus = -k, nothing = 0.0;
  add_lanes(R.x(row0[0], row1[0]), R.x(row0[1], row1[1]), R.x(m.vv[2], m.vv[4]), minus * sums[0], own);
  add_lanes(R.y(row0[1], row1[1]), R.y(m.vv[2], m.vv[4]), minus * sums[1], m.vv[5], own + 4);
  add_lanes(minus * m.v[2], k * k * m.w, R.x(m.sv[0], m.sv[1]), R.y(m.sv[0], m.sv[1]), own + 8);
  add_lanes(m.sv[2], minus * m.s, R.x(m.rv[0], m.rv[1]), R.y(m.rv[0], m.rv[1]), own + 12);
  add_lanes(m.rv[2], minus * m.r, nothing, nothing, own + 16);
}

/// Cholesky factor of the states' normal equations. An unobservable direction (heading of a single antenna)
/// is fixed: it is not coupled to others.
template <int n>
HWY_INLINE SmallCholesky<n, V> factor_of(const StopNormal& normal, double unobserved) {
  V largest = normal.A[0][0];
  for (int p = 1; p < n; ++p) largest = max(largest, normal.A[p][p]);
  const V floor = unobserved * (V(1.0) + largest);
  SmallCholesky<n, V> out;
  out.factor([&](int p, int q) -> V { return p == q ? normal.A[p][p] + floor : normal.A[p][q]; },
             [&](V pivot) -> V { return select(pivot > 0.5 * floor, pivot, 100.0 * floor); });
  return out;
}

/// Adds Y'Y for the waiting rows of Y to some rows of a block of `taken`.
template <std::size_t kHeld>
HWY_INLINE void add_schur_block(const Lanes* left, const Lanes* right, std::size_t stride,
                                std::size_t waiting, std::size_t part, double* block) {
  constexpr std::size_t kColumns = StopSums::kBlock;
  V sum[kHeld][kColumns];
  for (auto& row : sum)
    for (V& v : row) v = 0.0;
  for (std::size_t m = 0; m < waiting; ++m) {
    V r[kColumns];
    for (std::size_t k = 0; k < kColumns; ++k) r[k] = load(right[k * stride + m], part);
    for (std::size_t p = 0; p < kHeld; ++p) {
      const V l = load(left[p * stride + m], part);
      for (std::size_t q = 0; q < kColumns; ++q) sum[p][q] += l * r[q];
    }
  }
  for (std::size_t p = 0; p < kHeld; ++p)
    add_lanes(sum[p][0], sum[p][1], sum[p][2], sum[p][3], block + p * kColumns);
}

void add_schur_in_lanes(StopSums& sums) {
  // Number of rows that fit into the registers: 32 of them with AVX-512, otherwise 16.
  constexpr std::size_t kHeld = HWY_TARGET <= HWY_AVX3 ? 4 : 2, kBlock = StopSums::kBlock;
  const std::size_t states = sums.has_offset ? 4 : 3, stride = StopSums::kPacksAtOnce * states,
                    waiting = sums.waiting * states;
  const Lanes* rows = sums.rows.data();
  for (std::size_t part = 0; part < kLanes; part += lanes_at_once()) {
    double* block = sums.schur.data();
    for (std::size_t i = 0; i < sums.active.size(); i += kBlock)
      for (std::size_t j = i; j < sums.active.size(); j += kBlock, block += kBlock * kBlock)
        for (std::size_t r = 0; r < kBlock; r += kHeld)
          add_schur_block<kHeld>(rows + (i + r) * stride, rows + j * stride, stride, waiting, part,
                                 block + r * kBlock);
  }
}

/// Appends Y = L^-1 G of the active columns to the waiting rows, and subtracts the part of the states from
/// the gradient.
template <bool kOffset>
HWY_INLINE void eliminate(const StopNormal& normal, double unobserved, std::size_t part, StopSums& sums) {
  constexpr int n = kOffset ? 4 : 3;
  const SmallCholesky<n, V> factor = factor_of<n>(normal, unobserved);
  V y[n];
  for (int p = 0; p < n; ++p) y[p] = normal.g[p];
  factor.forward(y);
  const Lanes* const coupling = sums.coupling.data();
  const std::size_t count = sums.active.size();
  const std::size_t* const active = sums.active.data();
  Lanes* rows = sums.rows.data() + sums.waiting * n;
  double* const schur_gradient = sums.schur_gradient.data();
  for (std::size_t a = 0; a < count; a += 4) {
    V gradient[4];
    for (std::size_t i = 0; i < 4; ++i, rows += StopSums::kPacksAtOnce * n) {
      const Lanes* G = coupling + 4 * active[a + i];
      V Y[n];
      for (int p = 0; p < n; ++p) Y[p] = load(G[p], part);
      factor.forward(Y);
      gradient[i] = 0.0;
      for (int p = 0; p < n; ++p) {
        store(Y[p], rows[p], part);
        gradient[i] += y[p] * Y[p];
      }
    }
    add_lanes(gradient[0], gradient[1], gradient[2], gradient[3], schur_gradient + a);
  }
}

/// Coupling of the speed of the medium with the states and with itself.
struct SpeedSums {
  V curvature, gradient, by_state[4];
};

template <bool kOffset, bool kRobust>
HWY_INLINE void reduce_part(const StopTables tables, const StopPack pack, const StopStates& states,
                            const StopLayout& layout, double unobserved, std::size_t part, StopSums& sums) {
  // Copies, because values behind a reference would be read again after every store of a vector.
  const bool receivers_free = layout.receivers_free;
  const std::size_t receivers = layout.receivers, columns = layout.columns() + 1,
                    speed_column = layout.speed(), receiver_column = layout.of_receiver(0);
  double *const beacon_sums = sums.beacon.data(), *const receiver_sums = sums.receiver.data(),
                *const pair_sums = sums.pair.data();
  const Constants constants(tables);
  const View view(states, part);
  Lanes* coupling = sums.coupling.data();
  for (std::size_t c = 0; c < 4 * columns; ++c) store(0.0, coupling[c], part);
  StopNormal normal;
  normal.clear();
  SpeedSums speed{0.0, 0.0, {0.0, 0.0, 0.0, 0.0}};
  for (std::size_t slot = 0; slot < pack.slots;) {
    const std::size_t receiver = pack.slot[slot].receiver;
    const Antenna antenna(tables, receiver, view, constants);
    Moments all;
    all.clear();
    for (; slot < pack.slots && pack.slot[slot].receiver == receiver; ++slot) {
      const std::size_t beacon = pack.slot[slot].beacon;
      const PathSight s = sight_along<kRobust>(tables, pack, slot, part, antenna, constants);
      const V by_speed = by_speed_of(s, constants);
      const Moments m = moments_of(s, by_speed);
      speed.curvature += m.s * by_speed;
      speed.gradient += m.r * by_speed;
      all.add(m);
      m.add_to_sums(beacon_sums + StopSums::kMoments * beacon);
      couple_beacon<kOffset>(m, antenna, constants, part, coupling + 16 * beacon);
      if (receivers_free)
        add_pair(m, s, view, constants, pair_sums + StopSums::kPair * (beacon * receivers + receiver));
    }
    add_receiver<kOffset>(
        antenna, constants,
        {all.vv[0], all.vv[1], all.vv[3], all.rv[0], all.rv[1], all.v[0], all.v[1], all.w, all.r}, normal);
    speed.by_state[0] += all.sv[0];
    speed.by_state[1] += all.sv[1];
    speed.by_state[2] += V(antenna.rx * all.sv[1] - antenna.ry * all.sv[0]);
    if constexpr (kOffset) speed.by_state[3] += constants.by_offset * all.s;
    if (receivers_free)
      finish_receiver<kOffset>(all, antenna, view, constants, part,
                               coupling + 4 * (receiver_column + 4 * receiver),
                               receiver_sums + StopSums::kReceiver * receiver);
  }
  sums.speed_curvature += sum_of_lanes(speed.curvature);
  sums.speed_gradient += sum_of_lanes(speed.gradient);
  for (std::size_t p = 0; p < (kOffset ? 4 : 3); ++p)
    store(speed.by_state[p], coupling[4 * speed_column + p], part);
  if (pack.poses != nullptr) add_poses(pack, part, view, normal);
  eliminate<kOffset>(normal, unobserved, part, sums);
}

void reduce_stops_in_lanes(const StopTables& tables, const StopPack& pack, const StopStates& states,
                           const StopLayout& layout, double unobserved, StopSums& sums) {
  const bool robust = tables.late_scale > 0 && tables.early_scale > 0;
  for (std::size_t part = 0; part < kLanes; part += lanes_at_once()) {
    if (tables.has_offset) {
      robust ? reduce_part<true, true>(tables, pack, states, layout, unobserved, part, sums)
             : reduce_part<true, false>(tables, pack, states, layout, unobserved, part, sums);
    } else {
      robust ? reduce_part<false, true>(tables, pack, states, layout, unobserved, part, sums)
             : reduce_part<false, false>(tables, pack, states, layout, unobserved, part, sums);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace octant::calib
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::calib {

HWY_EXPORT(reduce_stops_in_lanes);
HWY_EXPORT(add_schur_in_lanes);

namespace {

void add_waiting_schur(StopSums& sums) {
  HWY_DYNAMIC_DISPATCH(add_schur_in_lanes)(sums);
  sums.waiting = 0;
}

}  // namespace

void reduce_stops(const StopTables& tables, const StopPack& pack, const StopStates& states,
                  const StopLayout& layout, double unobserved, StopSums& sums) {
  HWY_DYNAMIC_DISPATCH(reduce_stops_in_lanes)(tables, pack, states, layout, unobserved, sums);
  if (++sums.waiting == StopSums::kPacksAtOnce) add_waiting_schur(sums);
}

void StopSums::clear(const StopLayout& layout, bool offset) {
  const std::size_t receivers = layout.receivers_free ? layout.receivers : 0;
  has_offset = offset;
  active = layout.active;
  while (active.size() % kBlock != 0) active.push_back(layout.columns());
  beacon.assign(kMoments * layout.beacons, 0.0);
  receiver.assign(kReceiver * receivers, 0.0);
  pair.assign(kPair * layout.beacons * receivers, 0.0);
  const std::size_t side = active.size() / kBlock;
  schur.assign(side * (side + 1) / 2 * kBlock * kBlock, 0.0);
  schur_gradient.assign(active.size(), 0.0);
  speed_curvature = speed_gradient = 0.0;
  coupling.resize(4 * (layout.columns() + 1));
  rows.resize(active.size() * kPacksAtOnce * (offset ? 4 : 3));
  waiting = 0;
}

void StopSums::finish(const StopLayout& layout, double sigma_s, std::vector<double>& H,
                      std::vector<double>& gradient) {
  if (waiting > 0) add_waiting_schur(*this);
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
  for (std::size_t i = 0; i < count; ++i) gradient[active[i]] -= schur_gradient[i];
  const double* e = schur.data();
  for (std::size_t i = 0; i < count; i += kBlock)
    for (std::size_t j = i; j < count; j += kBlock)
      for (std::size_t r = i; r < i + kBlock; ++r)
        for (std::size_t c = j; c < j + kBlock; ++c, ++e)
          if (r < count && c < count && r <= c) element(active[r], active[c]) -= *e;
}

}  // namespace octant::calib
#endif
