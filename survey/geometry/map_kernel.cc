// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/map_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "survey/geometry/map_kernel.cc"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace octant::survey {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kMapLanes>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

constexpr double kMinDistanceM = 1e-6;
constexpr double kSingular = 1e-10;      ///< of a pivot against its diagonal
constexpr double kWorstDilution = 1e4;   ///< beyond it a geometry is singular to rounding, or as good as
constexpr double kNonCentrality = 4.13;  ///< 3.29 + 0.84: 0.1 %, power 80 %
constexpr double kNoise = 3.29;
constexpr double kUnnoticed = 1e-6;  ///< of a beacon's own information
constexpr double kNever = std::numeric_limits<double>::infinity();

HWY_INLINE V number(double value) { return hn::Set(D(), value); }

/// Poses of as many lanes as a vector has.
struct Poses {
  V x, y, z, cosine, sine;
};

HWY_INLINE Poses load_poses(const KernelTile& tile, std::size_t at) {
  const D d;
  return {hn::Load(d, tile.x_m + at), hn::Load(d, tile.y_m + at), hn::Load(d, tile.z_m + at),
          hn::Load(d, tile.cosine + at), hn::Load(d, tile.sine + at)};
}

/// Gain by linear interpolation over the cosine.
HWY_INLINE V gain_of(const double* table, V cosine) {
  const D d;
  const hn::RebindToSigned<D> di;
  const V at = hn::Mul(hn::Add(hn::Min(hn::Max(cosine, number(-1.0)), number(1.0)), number(1.0)),
                       number(kGainSteps / 2.0));
  const auto step = hn::Min(hn::ConvertTo(di, at), hn::Set(di, static_cast<std::int64_t>(kGainSteps) - 1));
  const V low = hn::GatherIndex(d, table, step), high = hn::GatherIndex(d, table + 1, step);
  return hn::MulAdd(hn::Sub(at, hn::ConvertTo(d, step)), hn::Sub(high, low), low);
}

/// One path from a beacon to a receiver: unit vector towards the receiver, length, and who hears.
struct Path {
  V ux, uy, uz, distance;
  V lx, ly;  ///< lever arm turned into the map
  V lz;
  M heard;
};

/// Both patterns, the reach and the threshold.
HWY_INLINE void listen(const KernelModel& model, const KernelTransducer& b, const KernelTransducer& r,
                       const Poses& at, Path& path) {
  path.heard = hn::Le(path.distance, number(model.reach_m));
  const bool directed_b = b.least_cosine > -2.0, directed_r = r.least_cosine > -2.0;
  if (!directed_b && !directed_r) return;
  V gain = number(1.0);
  if (directed_b) {
    const V c = hn::MulAdd(number(b.axis[0]), path.ux,
                           hn::MulAdd(number(b.axis[1]), path.uy, hn::Mul(number(b.axis[2]), path.uz)));
    path.heard = hn::And(path.heard, hn::Ge(c, number(b.least_cosine)));
    if (b.gain != nullptr) gain = gain_of(b.gain, c);
  }
  if (directed_r) {
    const V ax = hn::Sub(hn::Mul(at.cosine, number(r.axis[0])), hn::Mul(at.sine, number(r.axis[1])));
    const V ay = hn::Add(hn::Mul(at.sine, number(r.axis[0])), hn::Mul(at.cosine, number(r.axis[1])));
    const V c =
        hn::Neg(hn::MulAdd(ax, path.ux, hn::MulAdd(ay, path.uy, hn::Mul(number(r.axis[2]), path.uz))));
    path.heard = hn::And(path.heard, hn::Ge(c, number(r.least_cosine)));
    if (r.gain != nullptr) gain = hn::Mul(gain, gain_of(r.gain, c));
  }
  if (b.gain == nullptr && r.gain == nullptr) return;
  const V loss = hn::Exp(D(), hn::Mul(number(-model.absorption_np_per_m), path.distance));
  const V amplitude = hn::Mul(hn::Mul(number(model.amplitude_1m_v), gain), loss);
  path.heard = hn::And(path.heard, model.threshold_v > 0
                                       ? hn::Ge(amplitude, hn::Mul(number(model.threshold_v), path.distance))
                                       : hn::Gt(gain, hn::Zero(D())));
}

/// A wall between: its line parts beacon and receiver, the path's line parts its ends, and it is as high as
/// the crossing.
HWY_INLINE M blocked(const KernelWall& wall, const KernelTransducer& b, V px, V py, V pz) {
  const V sp = hn::Sub(hn::Mul(number(wall.wx_m), hn::Sub(py, number(wall.y_m))),
                       hn::Mul(number(wall.wy_m), hn::Sub(px, number(wall.x_m))));
  const V sb = number(wall.wx_m * (b.p_m[1] - wall.y_m) - wall.wy_m * (b.p_m[0] - wall.x_m));
  const V rx = hn::Sub(number(b.p_m[0]), px), ry = hn::Sub(number(b.p_m[1]), py);
  const V fx = hn::Sub(number(wall.x_m), px), fy = hn::Sub(number(wall.y_m), py);
  const V from = hn::Sub(hn::Mul(rx, fy), hn::Mul(ry, fx));
  const V to = hn::Add(from, hn::Sub(hn::Mul(rx, number(wall.wy_m)), hn::Mul(ry, number(wall.wx_m))));
  M between = hn::And(hn::Lt(hn::Mul(sp, sb), hn::Zero(D())), hn::Le(hn::Mul(from, to), hn::Zero(D())));
  if (wall.any_height) return between;
  const V z = hn::MulAdd(hn::Div(sp, hn::Sub(sp, sb)), hn::Sub(number(b.p_m[2]), pz), pz);
  return hn::And(between, hn::And(hn::Ge(z, number(wall.bottom_m)), hn::Le(z, number(wall.top_m))));
}

HWY_INLINE Path trace(const KernelModel& model, const KernelTile& tile, std::size_t beacon,
                      const KernelTransducer& r, const Poses& at) {
  const KernelTransducer& b = model.beacons[beacon];
  Path path;
  path.lx = hn::Sub(hn::Mul(at.cosine, number(r.p_m[0])), hn::Mul(at.sine, number(r.p_m[1])));
  path.ly = hn::Add(hn::Mul(at.sine, number(r.p_m[0])), hn::Mul(at.cosine, number(r.p_m[1])));
  path.lz = number(r.p_m[2]);
  const V px = hn::Add(at.x, path.lx), py = hn::Add(at.y, path.ly), pz = hn::Add(at.z, path.lz);
  const V dx = hn::Sub(px, number(b.p_m[0])), dy = hn::Sub(py, number(b.p_m[1])),
          dz = hn::Sub(pz, number(b.p_m[2]));
  path.distance =
      hn::Max(hn::Sqrt(hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)))), number(kMinDistanceM));
  const V inverse = hn::Div(number(1.0), path.distance);
  path.ux = hn::Mul(dx, inverse), path.uy = hn::Mul(dy, inverse), path.uz = hn::Mul(dz, inverse);
  listen(model, b, r, at, path);
  for (std::uint32_t w = tile.wall_first[beacon]; w < tile.wall_first[beacon + 1]; ++w) {
    if (hn::AllFalse(D(), path.heard)) return path;
    path.heard = hn::AndNot(blocked(tile.walls[w], b, px, py, pz), path.heard);
  }
  return path;
}

/// Derivatives of a range by the unknowns: the unit vector; by rotations l x R'u; by the clock's offset 1.
template <int kPosition, int kRotation, bool kClock>
HWY_INLINE void derivatives(const Path& path, const Poses& at, const KernelTransducer& r, V* j) {
  int n = 0;
  j[n++] = path.ux;
  j[n++] = path.uy;
  if constexpr (kPosition == 3) j[n++] = path.uz;
  if constexpr (kRotation > 0) {
    const V bx = hn::MulAdd(at.cosine, path.ux, hn::Mul(at.sine, path.uy)),
            by = hn::Sub(hn::Mul(at.cosine, path.uy), hn::Mul(at.sine, path.ux));
    if constexpr (kRotation == 3) {
      j[n++] = hn::Sub(hn::Mul(number(r.p_m[1]), path.uz), hn::Mul(number(r.p_m[2]), by));
      j[n++] = hn::Sub(hn::Mul(number(r.p_m[2]), bx), hn::Mul(number(r.p_m[0]), path.uz));
    }
    j[n++] = hn::Sub(hn::Mul(number(r.p_m[0]), by), hn::Mul(number(r.p_m[1]), bx));
  }
  if constexpr (kClock) j[n++] = number(1.0);
}

/// The inverse of a packed symmetric matrix, by Cholesky; lanes where it is singular come out with `sound`
/// off.
template <int N>
HWY_INLINE void invert(const V* packed, V* inverse, M& sound) {
  V A[N][N], L[N][N];
  for (int p = 0, e = 0; p < N; ++p)
    for (int q = p; q < N; ++q, ++e) A[q][p] = packed[e];
  for (int p = 0; p < N; ++p) {
    V pivot = A[p][p];
    for (int m = 0; m < p; ++m) pivot = hn::NegMulAdd(L[p][m], L[p][m], pivot);
    const M good = hn::Gt(pivot, hn::Mul(number(kSingular), A[p][p]));
    sound = p == 0 ? good : hn::And(sound, good);
    const V root = hn::Div(number(1.0), hn::Sqrt(hn::IfThenElse(good, pivot, number(1.0))));
    for (int q = p + 1; q < N; ++q) {
      V v = A[q][p];
      for (int m = 0; m < p; ++m) v = hn::NegMulAdd(L[q][m], L[p][m], v);
      L[q][p] = hn::Mul(v, root);
    }
    L[p][p] = root;  // kept as its inverse
  }
  // K = L^-1, row by row in place of L; then A^-1 = K'K.
  for (int p = 0; p < N; ++p)
    for (int q = p - 1; q >= 0; --q) {
      V v = hn::Zero(D());
      for (int m = q; m < p; ++m) v = hn::NegMulAdd(L[p][m], m == q ? L[q][q] : A[m][q], v);
      A[p][q] = hn::Mul(v, L[p][p]);  // A's lower part is done with: it takes K
    }
  const auto K = [&](int p, int q) HWY_ATTR { return p == q ? L[p][p] : A[p][q]; };
  for (int p = 0, e = 0; p < N; ++p)
    for (int q = p; q < N; ++q, ++e) {
      V v = hn::Mul(K(q, p), K(q, q));
      for (int m = q + 1; m < N; ++m) v = hn::MulAdd(K(m, p), K(m, q), v);
      inverse[e] = v;
    }
}

constexpr int entry(int n, int p, int q) {
  return p <= q ? p * n - p * (p - 1) / 2 + (q - p) : entry(n, q, p);
}

template <int N>
HWY_INLINE void multiply(const V* packed, const V* vector, V* product) {
  for (int p = 0; p < N; ++p) {
    V v = hn::Mul(packed[entry(N, p, 0)], vector[0]);
    for (int q = 1; q < N; ++q) v = hn::MulAdd(packed[entry(N, p, q)], vector[q], v);
    product[p] = v;
  }
}

template <int kPosition, int kRotation, bool kClock>
class Tile {
 public:
  static constexpr int N = kPosition + kRotation + (kClock ? 1 : 0), E = N * (N + 1) / 2;

  /// Normal equations of the poses at `at`, from one beacon.
  static HWY_INLINE void add_beacon(const KernelModel& model, const KernelTile& tile, std::size_t beacon,
                                    const Poses& at, V* information, V* plain, V* by_speed, V* sum, V& weight,
                                    V& arrivals) {
    const bool grows = model.per_m2 != 0.0 || model.per_sqrt_m2 != 0.0;
    const V constant = number(1.0 / model.constant_m2);
    for (const KernelTransducer& r : model.receivers) {
      const Path path = trace(model, tile, beacon, r, at);
      if (hn::AllFalse(D(), path.heard)) continue;
      V j[N];
      derivatives<kPosition, kRotation, kClock>(path, at, r, j);
      V w = constant;
      if (grows) {
        const V spread = hn::MulAdd(number(model.per_m2), path.distance, number(model.per_sqrt_m2));
        w = hn::Div(number(1.0), hn::MulAdd(spread, path.distance, number(model.constant_m2)));
      }
      w = hn::IfThenElseZero(path.heard, w);
      const V one = hn::IfThenElseZero(path.heard, number(1.0)), wd = hn::Mul(w, path.distance);
      arrivals = hn::Add(arrivals, one);
      weight = hn::Add(weight, w);
      for (int p = 0, e = 0; p < N; ++p) {
        const V wj = hn::Mul(w, j[p]);
        sum[p] = hn::Add(sum[p], wj);
        by_speed[p] = hn::MulAdd(wd, j[p], by_speed[p]);
        for (int q = p; q < N; ++q, ++e) {
          information[e] = hn::MulAdd(wj, j[q], information[e]);
          if (grows) plain[e] = hn::MulAdd(hn::Mul(one, j[p]), j[q], plain[e]);
        }
      }
    }
  }

  static void map(const KernelModel& model, const KernelTile& tile, bool integrity, KernelWork& work,
                  KernelFigures& out) {
    const std::size_t lanes = hn::Lanes(D()), beacons = model.beacons.size();
    if (integrity) work.of_beacon.resize(beacons * (N + 2) * kMapLanes);
    work.heard_bits.assign(beacons * (kTilePoses / 8), 0);
    for (std::size_t at = 0; at < tile.count; at += lanes) {
      const Poses poses = load_poses(tile, at);
      V information[E], plain[E], by_speed[N];
      for (int e = 0; e < E; ++e) information[e] = plain[e] = hn::Zero(D());
      for (int p = 0; p < N; ++p) by_speed[p] = hn::Zero(D());
      V heard = hn::Zero(D()), arrivals = hn::Zero(D());
      double* kept = work.of_beacon.data();
      for (std::size_t b = 0; b < beacons; ++b) {
        if (tile.skip[b]) continue;
        V sum[N], weight = hn::Zero(D());
        for (int p = 0; p < N; ++p) sum[p] = hn::Zero(D());
        add_beacon(model, tile, b, poses, information, plain, by_speed, sum, weight, arrivals);
        const M any = hn::Gt(weight, hn::Zero(D()));
        if (hn::AllFalse(D(), any)) continue;
        heard = hn::Add(heard, hn::IfThenElseZero(any, number(1.0)));
        std::uint8_t bits[8] = {};
        hn::StoreMaskBits(D(), any, bits);
        work.heard_bits[b * (kTilePoses / 8) + at / 8] |= static_cast<std::uint8_t>(bits[0] << (at % 8));
        if (!integrity) continue;
        for (int p = 0; p < N; ++p) hn::StoreU(sum[p], D(), kept + static_cast<std::size_t>(p) * lanes);
        hn::StoreU(weight, D(), kept + static_cast<std::size_t>(N) * lanes);
        kept += static_cast<std::size_t>(N + 1) * lanes;
      }
      finish(model, at, information, plain, by_speed, integrity, work.of_beacon.data(), kept, out);
      hn::Store(heard, D(), out.value[kBeacons] + at);
      hn::Store(arrivals, D(), out.value[kArrivals] + at);
    }
  }

  static void layer(const KernelModel& model, const KernelTile& tile, std::size_t beacon,
                    double* information_out, double* heard) {
    for (std::size_t at = 0; at < tile.count; at += hn::Lanes(D())) {
      V information[E], plain[E], by_speed[N], sum[N], weight = hn::Zero(D()), arrivals = hn::Zero(D());
      for (int e = 0; e < E; ++e) information[e] = plain[e] = hn::Zero(D());
      for (int p = 0; p < N; ++p) by_speed[p] = sum[p] = hn::Zero(D());
      if (!tile.skip[beacon])
        add_beacon(model, tile, beacon, load_poses(tile, at), information, plain, by_speed, sum, weight,
                   arrivals);
      for (int e = 0; e < E; ++e)
        hn::StoreU(information[e], D(), information_out + static_cast<std::size_t>(e) * kTilePoses + at);
      hn::StoreU(hn::IfThenElseZero(hn::Gt(weight, hn::Zero(D())), number(1.0)), D(), heard + at);
    }
  }

 private:
  static HWY_INLINE void put(std::size_t figure, std::size_t at, M sound, V square, KernelFigures& out) {
    hn::Store(hn::IfThenElse(sound, hn::Sqrt(hn::Max(square, hn::Zero(D()))), number(kNever)), D(),
              out.value[figure] + at);
  }

  static HWY_INLINE void finish(const KernelModel& model, std::size_t at, const V* information,
                                const V* plain, const V* by_speed, bool integrity, const double* kept,
                                const double* end, KernelFigures& out) {
    V C[E], Q[E];
    M sound;
    invert<N>(information, C, sound);
    if (model.per_m2 != 0.0 || model.per_sqrt_m2 != 0.0) {
      M plain_sound;
      invert<N>(plain, Q, plain_sound);
      sound = hn::And(sound, plain_sound);
    } else {
      for (int e = 0; e < E; ++e) Q[e] = hn::Mul(C[e], number(1.0 / model.constant_m2));
    }
    sound = hn::And(sound, hn::Lt(hn::Add(Q[0], Q[entry(N, 1, 1)]), number(kWorstDilution * kWorstDilution)));
    const auto diagonal = [](const V* packed, int p) HWY_ATTR { return packed[entry(N, p, p)]; };
    const V zero = hn::Zero(D());
    const V h = hn::Add(diagonal(Q, 0), diagonal(Q, 1)), v = kPosition == 3 ? diagonal(Q, 2) : zero,
            t = kClock ? diagonal(Q, N - 1) : zero;
    constexpr int kHeading = kPosition + kRotation - 1;
    put(kHdop, at, sound, h, out);
    put(kVdop, at, sound, v, out);
    put(kPdop, at, sound, hn::Add(h, v), out);
    put(kTdop, at, sound, t, out);
    put(kGdop, at, sound, hn::Add(hn::Add(h, v), t), out);
    put(kHeadingDop, at, sound, kRotation > 0 ? diagonal(Q, kHeading) : zero, out);
    put(kSigma, at, sound, hn::Add(diagonal(C, 0), diagonal(C, 1)), out);
    put(kSigmaX, at, sound, diagonal(C, 0), out);
    put(kSigmaY, at, sound, diagonal(C, 1), out);
    put(kSigmaZ, at, sound, kPosition == 3 ? diagonal(C, 2) : zero, out);
    put(kSigmaHeading, at, sound, kRotation > 0 ? diagonal(C, kHeading) : zero, out);
    hn::Store(hn::IfThenElseZero(sound, C[1]), D(), out.value[kCovarianceXy] + at);
    V shift[N];
    multiply<N>(C, by_speed, shift);
    put(kShiftBySpeed, at, sound, hn::MulAdd(shift[0], shift[0], hn::Mul(shift[1], shift[1])), out);
    if (integrity) protect(at, C, sound, kept, end, out);
  }

  /// Each beacon at fault in its turn: a bias of all its ranges that the others would just not notice, and
  /// what it does.
  static HWY_INLINE void protect(std::size_t at, const V* C, M sound, const double* kept, const double* end,
                                 KernelFigures& out) {
    const std::size_t lanes = hn::Lanes(D());
    V bias2 = hn::Zero(D()), worst2 = hn::Zero(D());
    M noticed = sound;
    for (; kept != end; kept += static_cast<std::size_t>(N + 1) * lanes) {
      V sum[N], moved[N];
      for (int p = 0; p < N; ++p) sum[p] = hn::LoadU(D(), kept + static_cast<std::size_t>(p) * lanes);
      const V weight = hn::LoadU(D(), kept + static_cast<std::size_t>(N) * lanes);
      const M heard = hn::Gt(weight, hn::Zero(D()));
      multiply<N>(C, sum, moved);
      V left = weight;
      for (int p = 0; p < N; ++p) left = hn::NegMulAdd(sum[p], moved[p], left);
      const M seen = hn::Gt(left, hn::Mul(number(kUnnoticed), weight));
      noticed = hn::And(noticed, hn::Or(seen, hn::Not(heard)));
      const V square =
          hn::IfThenElseZero(hn::And(heard, seen), hn::Div(number(kNonCentrality * kNonCentrality), left));
      bias2 = hn::Max(bias2, square);
      worst2 = hn::Max(worst2, hn::Mul(square, hn::MulAdd(moved[0], moved[0], hn::Mul(moved[1], moved[1]))));
    }
    put(kDetectableBias, at, noticed, bias2, out);
    put(kFaultShift, at, noticed, worst2, out);
    const V middle = hn::Mul(number(0.5), hn::Add(C[0], C[entry(N, 1, 1)])),
            half = hn::Mul(number(0.5), hn::Sub(C[0], C[entry(N, 1, 1)]));
    const V largest = hn::Add(middle, hn::Sqrt(hn::MulAdd(half, half, hn::Mul(C[1], C[1]))));
    const V level = hn::MulAdd(number(kNoise), hn::Sqrt(hn::Max(largest, hn::Zero(D()))), hn::Sqrt(worst2));
    hn::Store(hn::IfThenElse(noticed, level, number(kNever)), D(), out.value[kProtection] + at);
  }
};

/// Calls with the Tile of these unknowns.
template <class Call>
HWY_INLINE void with_unknowns(const Unknowns& u, Call call) {
  if (u.position == 2) {
    if (u.rotation == 0) return u.clock ? call(Tile<2, 0, true>()) : call(Tile<2, 0, false>());
    return u.clock ? call(Tile<2, 1, true>()) : call(Tile<2, 1, false>());
  }
  if (u.rotation == 0) return u.clock ? call(Tile<3, 0, true>()) : call(Tile<3, 0, false>());
  return u.clock ? call(Tile<3, 3, true>()) : call(Tile<3, 3, false>());
}

void map_tile_in_lanes(const KernelModel& model, const KernelTile& tile, bool integrity, KernelWork& work,
                       KernelFigures& figures) {
  with_unknowns(model.unknowns,
                [&](auto kind) HWY_ATTR { decltype(kind)::map(model, tile, integrity, work, figures); });
}

void layer_tile_in_lanes(const KernelModel& model, const KernelTile& tile, std::size_t beacon,
                         double* information, double* heard) {
  with_unknowns(model.unknowns,
                [&](auto kind) HWY_ATTR { decltype(kind)::layer(model, tile, beacon, information, heard); });
}

/// Eliminates the unknowns behind x and y, last ones first, and inverts what is left.
template <int N>
HWY_INLINE V horizontal_sigma(V* A, const V* before) {
  M sound = hn::Eq(number(0.0), number(0.0));
  for (int m = N - 1; m >= 2; --m) {
    const V pivot = A[entry(N, m, m)];
    const M good = hn::Gt(pivot, hn::Mul(number(kSingular), before[m]));
    sound = hn::And(sound, good);
    const V inverse = hn::Div(number(1.0), hn::IfThenElse(good, pivot, number(1.0)));
    for (int p = 0; p < m; ++p) {
      const V factor = hn::Mul(A[entry(N, p, m)], inverse);
      for (int q = p; q < m; ++q)
        A[entry(N, p, q)] = hn::NegMulAdd(factor, A[entry(N, q, m)], A[entry(N, p, q)]);
    }
  }
  const V xx = A[0], xy = A[1], yy = A[entry(N, 1, 1)];
  const V determinant = hn::NegMulAdd(xy, xy, hn::Mul(xx, yy));
  const M good = hn::And(hn::Gt(xx, hn::Mul(number(kSingular), before[0])),
                         hn::Gt(determinant, hn::Mul(hn::Mul(number(kSingular), before[1]), xx)));
  sound = hn::And(sound, good);
  const V square = hn::Div(hn::Add(xx, yy), hn::IfThenElse(sound, determinant, number(1.0)));
  // As many ranges as there were, of their mean weight: the square of the dilution times their number.
  sound = hn::And(sound, hn::Lt(hn::Mul(square, hn::Add(before[0], before[1])),
                                number(10 * kWorstDilution * kWorstDilution)));
  return hn::IfThenElse(sound, hn::Sqrt(hn::Max(square, hn::Zero(D()))), number(kNever));
}

template <int N>
HWY_INLINE void sigma_of_packed_n(const double* information, const double* less, const double* less_too,
                                  std::size_t stride, std::size_t count, double* sigma_m) {
  constexpr int E = N * (N + 1) / 2;
  const std::size_t lanes = hn::Lanes(D());
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
      return tail ? hn::LoadU(D(), padded[which][e])
                  : hn::LoadU(D(), values + static_cast<std::size_t>(e) * stride + at);
    };
    V A[E], before[N];
    for (int e = 0; e < E; ++e) A[e] = load(information, 0, e);
    for (int p = 0; p < N; ++p) before[p] = A[entry(N, p, p)];
    if (less != nullptr)
      for (int e = 0; e < E; ++e) A[e] = hn::Sub(A[e], load(less, 1, e));
    if (less_too != nullptr)
      for (int e = 0; e < E; ++e) A[e] = hn::Sub(A[e], load(less_too, 2, e));
    const V sigma = horizontal_sigma<N>(A, before);
    if (!tail) {
      hn::StoreU(sigma, D(), sigma_m + at);
    } else {
      alignas(64) double last[kMapLanes];
      hn::Store(sigma, D(), last);
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
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    hn::StoreU(hn::Add(hn::LoadU(d, term + i), hn::LoadU(d, sum + i)), d, sum + i);
  for (; i < count; ++i) sum[i] += term[i];
}

}  // namespace HWY_NAMESPACE
}  // namespace octant::survey
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::survey {

HWY_EXPORT(map_tile_in_lanes);
HWY_EXPORT(layer_tile_in_lanes);
HWY_EXPORT(sigma_of_packed_in_lanes);
HWY_EXPORT(add_to_in_lanes);

void map_tile(const KernelModel& model, const KernelTile& tile, bool integrity, KernelWork& work,
              KernelFigures& figures) {
  HWY_DYNAMIC_DISPATCH(map_tile_in_lanes)(model, tile, integrity, work, figures);
}

void layer_tile(const KernelModel& model, const KernelTile& tile, std::size_t beacon, double* information,
                double* heard) {
  HWY_DYNAMIC_DISPATCH(layer_tile_in_lanes)(model, tile, beacon, information, heard);
}

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
