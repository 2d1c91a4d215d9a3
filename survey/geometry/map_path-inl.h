// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Private to survey/: paths between beacons and receivers for as many poses as a vector has lanes. Compiled
// once for each instruction set, within map_kernel.cc.
#if defined(OCTANT_SURVEY_GEOMETRY_MAP_PATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTANT_SURVEY_GEOMETRY_MAP_PATH_INL_H_
#undef OCTANT_SURVEY_GEOMETRY_MAP_PATH_INL_H_
#else
#define OCTANT_SURVEY_GEOMETRY_MAP_PATH_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "models/support/vector-inl.h"
#include "survey/geometry/kernel_tile.h"

HWY_BEFORE_NAMESPACE();
namespace octant::survey {
namespace HWY_NAMESPACE {

using namespace octant::HWY_NAMESPACE;  // NOLINT(google-build-using-namespace): this instruction set's
using V = Vector;

constexpr double kMinDistanceM = 1e-6;

/// Poses, one in each lane of a vector.
struct Poses {
  V x, y, z, cosine, sine;
};

HWY_INLINE Poses load_poses(const KernelTile& tile, std::size_t at) {
  return {load(tile.x_m + at), load(tile.y_m + at), load(tile.z_m + at), load(tile.cosine + at),
          load(tile.sine + at)};
}

/// Gain by linear interpolation over the cosine.
HWY_INLINE V gain_of(const double* table, V cosine) {
  const Doubles d;
  const hn::RebindToSigned<Doubles> di;
  const V at = (min(max(cosine, -1.0), 1.0) + 1.0) * (kGainSteps / 2.0);
  const auto step =
      hn::Min(hn::ConvertTo(di, at.raw), hn::Set(di, static_cast<std::int64_t>(kGainSteps) - 1));
  const V low = hn::GatherIndex(d, table, step), high = hn::GatherIndex(d, table + 1, step);
  return (at - V(hn::ConvertTo(d, step))) * (high - low) + low;
}

/// Path from a beacon to a receiver: unit vector towards the receiver, length, and the lanes that receive it.
struct Path {
  V ux, uy, uz, distance;
  V lx, ly;  ///< lever arm turned into the map
  V lz;
  Mask heard;
};

/// Both patterns, the reach and the threshold.
HWY_INLINE void listen(const KernelModel& model, const KernelTransducer& b, const KernelTransducer& r,
                       const Poses& at, Path& path) {
  path.heard = path.distance <= model.reach_m;
  const bool directed_b = b.least_cosine > -2.0, directed_r = r.least_cosine > -2.0;
  if (!directed_b && !directed_r) return;
  V gain = 1.0;
  if (directed_b) {
    const V c = b.axis[0] * path.ux + (b.axis[1] * path.uy + b.axis[2] * path.uz);
    path.heard = path.heard & (c >= b.least_cosine);
    if (b.gain != nullptr) gain = gain_of(b.gain, c);
  }
  if (directed_r) {
    const V ax = at.cosine * r.axis[0] - at.sine * r.axis[1];
    const V ay = at.sine * r.axis[0] + at.cosine * r.axis[1];
    const V c = -(ax * path.ux + (ay * path.uy + r.axis[2] * path.uz));
    path.heard = path.heard & (c >= r.least_cosine);
    if (r.gain != nullptr) gain = gain * gain_of(r.gain, c);
  }
  if (b.gain == nullptr && r.gain == nullptr) return;
  const V loss = exp(-model.absorption_np_per_m * path.distance);
  const V amplitude = model.amplitude_1m_v * gain * loss;
  path.heard =
      path.heard & (model.threshold_v > 0 ? amplitude >= model.threshold_v * path.distance : gain > 0.0);
}

/// A wall between: its line parts beacon and receiver, the path's line parts its ends, and it is as high as
/// the crossing.
HWY_INLINE Mask blocked(const KernelWall& wall, const KernelTransducer& b, V px, V py, V pz) {
  const V sp = wall.wx_m * (py - wall.y_m) - wall.wy_m * (px - wall.x_m);
  const V sb = wall.wx_m * (b.p_m[1] - wall.y_m) - wall.wy_m * (b.p_m[0] - wall.x_m);
  const V rx = b.p_m[0] - px, ry = b.p_m[1] - py;
  const V fx = wall.x_m - px, fy = wall.y_m - py;
  const V from = rx * fy - ry * fx;
  const V to = from + (rx * wall.wy_m - ry * wall.wx_m);
  Mask between = (sp * sb < 0.0) & (from * to <= 0.0);
  if (wall.any_height) return between;
  const V z = sp / (sp - sb) * (b.p_m[2] - pz) + pz;
  return between & ((z >= wall.bottom_m) & (z <= wall.top_m));
}

HWY_INLINE Path trace(const KernelModel& model, const KernelTile& tile, std::size_t beacon,
                      const KernelTransducer& r, const Poses& at) {
  const KernelTransducer& b = model.beacons[beacon];
  Path path;
  // Each product rounds by itself: they are the same for all beacons and leave the loop.
  path.lx = V(at.cosine * r.p_m[0]) - V(at.sine * r.p_m[1]);
  path.ly = V(at.sine * r.p_m[0]) + V(at.cosine * r.p_m[1]);
  path.lz = r.p_m[2];
  const V px = at.x + path.lx, py = at.y + path.ly, pz = at.z + path.lz;
  const V dx = px - b.p_m[0], dy = py - b.p_m[1], dz = pz - b.p_m[2];
  path.distance = max(sqrt(dx * dx + (dy * dy + dz * dz)), kMinDistanceM);
  const V inverse = 1.0 / path.distance;
  path.ux = dx * inverse, path.uy = dy * inverse, path.uz = dz * inverse;
  listen(model, b, r, at, path);
  for (std::uint32_t w = tile.wall_first[beacon]; w < tile.wall_first[beacon + 1]; ++w) {
    if (none(path.heard)) return path;
    path.heard = but_not(path.heard, blocked(tile.walls[w], b, px, py, pz));
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
    const V bx = at.cosine * path.ux + at.sine * path.uy, by = at.cosine * path.uy - at.sine * path.ux;
    if constexpr (kRotation == 3) {
      j[n++] = r.p_m[1] * path.uz - r.p_m[2] * by;
      j[n++] = r.p_m[2] * bx - r.p_m[0] * path.uz;
    }
    j[n++] = r.p_m[0] * by - r.p_m[1] * bx;
  }
  if constexpr (kClock) j[n++] = 1.0;
}

}  // namespace HWY_NAMESPACE
}  // namespace octant::survey
HWY_AFTER_NAMESPACE();

#endif
