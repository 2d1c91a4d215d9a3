// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/map_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "survey/geometry/map_kernel.cc"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set
#include <hwy/highway.h>

#include "survey/geometry/map_path-inl.h"
#include "survey/geometry/packed-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octant::survey {
namespace HWY_NAMESPACE {

constexpr double kNonCentrality = 4.13;  ///< 3.29 + 0.84: 0.1 %, power 80 %
constexpr double kNoise = 3.29;
constexpr double kUnnoticed = 1e-6;  ///< relative to the information of the beacon

template <int kPosition, int kRotation, bool kClock>
class Tile {
 public:
  static constexpr int N = kPosition + kRotation + (kClock ? 1 : 0), E = N * (N + 1) / 2;

  /// Normal equations of the poses at `at`, from one beacon.
  static HWY_INLINE void add_beacon(const KernelModel& model, const KernelTile& tile, std::size_t beacon,
                                    const Poses& at, V* information, V* plain, V* by_speed, V* sum, V& weight,
                                    V& arrivals) {
    const bool grows = model.per_m2 != 0.0 || model.per_sqrt_m2 != 0.0;
    const V constant = (1.0 / model.constant_m2);
    for (const KernelTransducer& r : model.receivers) {
      const Path path = trace(model, tile, beacon, r, at);
      if (none(path.heard)) continue;
      V j[N];
      derivatives<kPosition, kRotation, kClock>(path, at, r, j);
      V w = constant;
      if (grows) {
        const V spread = model.per_m2 * path.distance + model.per_sqrt_m2;
        w = 1.0 / (spread * path.distance + model.constant_m2);
      }
      w = only(path.heard, w);
      const V one = only(path.heard, 1.0), wd = w * path.distance;
      arrivals += one;
      weight += w;
      for (int p = 0, e = 0; p < N; ++p) {
        const V wj = w * j[p];
        sum[p] += wj;
        by_speed[p] += wd * j[p];
        for (int q = p; q < N; ++q, ++e) {
          information[e] += wj * j[q];
          if (grows) plain[e] += one * j[p] * j[q];
        }
      }
    }
  }

  static void map(const KernelModel& model, const KernelTile& tile, bool integrity, KernelWork& work,
                  KernelFigures& out) {
    const std::size_t lanes = lanes_at_once(), beacons = model.beacons.size();
    if (integrity) work.of_beacon.resize(beacons * (N + 2) * kMapLanes);
    work.heard_bits.assign(beacons * (kTilePoses / 8), 0);
    for (std::size_t at = 0; at < tile.count; at += lanes) {
      const Poses poses = load_poses(tile, at);
      V information[E], plain[E], by_speed[N];
      for (int e = 0; e < E; ++e) information[e] = plain[e] = 0.0;
      for (int p = 0; p < N; ++p) by_speed[p] = 0.0;
      V heard = 0.0, arrivals = 0.0;
      double* kept = work.of_beacon.data();
      for (std::size_t b = 0; b < beacons; ++b) {
        if (tile.skip[b]) continue;
        V sum[N], weight = 0.0;
        for (int p = 0; p < N; ++p) sum[p] = 0.0;
        add_beacon(model, tile, b, poses, information, plain, by_speed, sum, weight, arrivals);
        const Mask any = weight > 0.0;
        if (none(any)) continue;
        heard += only(any, 1.0);
        std::uint8_t bits[8] = {};
        hn::StoreMaskBits(Doubles(), any.raw, bits);
        work.heard_bits[b * (kTilePoses / 8) + at / 8] |= static_cast<std::uint8_t>(bits[0] << (at % 8));
        if (!integrity) continue;
        for (int p = 0; p < N; ++p) store_unaligned(sum[p], kept + static_cast<std::size_t>(p) * lanes);
        store_unaligned(weight, kept + static_cast<std::size_t>(N) * lanes);
        kept += static_cast<std::size_t>(N + 1) * lanes;
      }
      finish(model, at, information, plain, by_speed, integrity, work.of_beacon.data(), kept, out);
      store(heard, out.value[kBeacons] + at);
      store(arrivals, out.value[kArrivals] + at);
    }
  }

  static void layer(const KernelModel& model, const KernelTile& tile, std::size_t beacon,
                    double* information_out, double* heard) {
    for (std::size_t at = 0; at < tile.count; at += lanes_at_once()) {
      V information[E], plain[E], by_speed[N], sum[N], weight = 0.0, arrivals = 0.0;
      for (int e = 0; e < E; ++e) information[e] = plain[e] = 0.0;
      for (int p = 0; p < N; ++p) by_speed[p] = sum[p] = 0.0;
      if (!tile.skip[beacon])
        add_beacon(model, tile, beacon, load_poses(tile, at), information, plain, by_speed, sum, weight,
                   arrivals);
      for (int e = 0; e < E; ++e)
        store_unaligned(information[e], information_out + static_cast<std::size_t>(e) * kTilePoses + at);
      store_unaligned(only(weight > 0.0, 1.0), heard + at);
    }
  }

 private:
  static HWY_INLINE void put(std::size_t figure, std::size_t at, Mask sound, V square, KernelFigures& out) {
    store(select(sound, sqrt(max(square, 0.0)), kNever), out.value[figure] + at);
  }

  static HWY_INLINE void finish(const KernelModel& model, std::size_t at, const V* information,
                                const V* plain, const V* by_speed, bool integrity, const double* kept,
                                const double* end, KernelFigures& out) {
    V C[E], Q[E];
    Mask sound;
    invert<N>(information, C, sound);
    if (model.per_m2 != 0.0 || model.per_sqrt_m2 != 0.0) {
      Mask plain_sound;
      invert<N>(plain, Q, plain_sound);
      sound = sound & plain_sound;
    } else {
      for (int e = 0; e < E; ++e) Q[e] = C[e] * (1.0 / model.constant_m2);
    }
    sound = sound & (Q[0] + Q[entry(N, 1, 1)] < kWorstDilution * kWorstDilution);
    const auto diagonal = [](const V* packed, int p) HWY_ATTR { return packed[entry(N, p, p)]; };
    const V zero = 0.0;
    const V h = diagonal(Q, 0) + diagonal(Q, 1), v = kPosition == 3 ? diagonal(Q, 2) : zero,
            t = kClock ? diagonal(Q, N - 1) : zero;
    constexpr int kHeading = kPosition + kRotation - 1;
    put(kHdop, at, sound, h, out);
    put(kVdop, at, sound, v, out);
    put(kPdop, at, sound, h + v, out);
    put(kTdop, at, sound, t, out);
    put(kGdop, at, sound, h + v + t, out);
    put(kHeadingDop, at, sound, kRotation > 0 ? diagonal(Q, kHeading) : zero, out);
    put(kSigma, at, sound, diagonal(C, 0) + diagonal(C, 1), out);
    put(kSigmaX, at, sound, diagonal(C, 0), out);
    put(kSigmaY, at, sound, diagonal(C, 1), out);
    put(kSigmaZ, at, sound, kPosition == 3 ? diagonal(C, 2) : zero, out);
    put(kSigmaHeading, at, sound, kRotation > 0 ? diagonal(C, kHeading) : zero, out);
    store(only(sound, C[1]), out.value[kCovarianceXy] + at);
    V shift[N];
    multiply<N>(C, by_speed, shift);
    put(kShiftBySpeed, at, sound, shift[0] * shift[0] + shift[1] * shift[1], out);
    if (integrity) protect(at, C, sound, kept, end, out);
  }

  /// For each beacon in turn: the largest common bias of its ranges that the others do not detect, and its
  /// effect.
  static HWY_INLINE void protect(std::size_t at, const V* C, Mask sound, const double* kept,
                                 const double* end, KernelFigures& out) {
    const std::size_t lanes = lanes_at_once();
    V bias2 = 0.0, worst2 = 0.0;
    Mask noticed = sound;
    for (; kept != end; kept += static_cast<std::size_t>(N + 1) * lanes) {
      V sum[N], moved[N];
      for (int p = 0; p < N; ++p) sum[p] = load_unaligned(kept + static_cast<std::size_t>(p) * lanes);
      const V weight = load_unaligned(kept + static_cast<std::size_t>(N) * lanes);
      const Mask heard = weight > 0.0;
      multiply<N>(C, sum, moved);
      V left = weight;
      for (int p = 0; p < N; ++p) left -= sum[p] * moved[p];
      const Mask seen = left > kUnnoticed * weight;
      noticed = noticed & (seen | !heard);
      const V square = only(heard & seen, kNonCentrality * kNonCentrality / left);
      bias2 = max(bias2, square);
      worst2 = max(worst2, square * (moved[0] * moved[0] + moved[1] * moved[1]));
    }
    put(kDetectableBias, at, noticed, bias2, out);
    put(kFaultShift, at, noticed, worst2, out);
    const V middle = 0.5 * (C[0] + C[entry(N, 1, 1)]), half = 0.5 * (C[0] - C[entry(N, 1, 1)]);
    const V largest = middle + sqrt(half * half + C[1] * C[1]);
    const V level = kNoise * sqrt(max(largest, 0.0)) + sqrt(worst2);
    store(select(noticed, level, kNever), out.value[kProtection] + at);
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

}  // namespace HWY_NAMESPACE
}  // namespace octant::survey
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::survey {

HWY_EXPORT(map_tile_in_lanes);
HWY_EXPORT(layer_tile_in_lanes);

void map_tile(const KernelModel& model, const KernelTile& tile, bool integrity, KernelWork& work,
              KernelFigures& figures) {
  HWY_DYNAMIC_DISPATCH(map_tile_in_lanes)(model, tile, integrity, work, figures);
}

void layer_tile(const KernelModel& model, const KernelTile& tile, std::size_t beacon, double* information,
                double* heard) {
  HWY_DYNAMIC_DISPATCH(layer_tile_in_lanes)(model, tile, beacon, information, heard);
}

}  // namespace octant::survey
#endif
