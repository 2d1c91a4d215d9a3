// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: a model and a tile of poses in the form that the SIMD kernels need.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "survey/geometry/geometry_figures.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

inline constexpr std::size_t kMapLanes = 8;      ///< poses side by side; narrower machines take them in turns
inline constexpr std::size_t kTilePoses = 512;   ///< at most, of one call
inline constexpr std::size_t kGainSteps = 4096;  ///< entries of a gain table over the cosine from -1 to 1

/// A transducer in flat numbers: beacon in the map, receiver in the vehicle's frame.
struct KernelTransducer {
  double p_m[3] = {}, axis[3] = {};
  double least_cosine = -2.0;    ///< no reception below this cosine; -2: in all directions
  const double* gain = nullptr;  ///< kGainSteps + 1 values over the cosine; null: 1
};

/// A wall's piece from (x, y) on, by (wx, wy).
struct KernelWall {
  double x_m, y_m, wx_m, wy_m, bottom_m, top_m;
  bool any_height;  ///< as high as every path that it could cross
};

struct KernelModel {
  Unknowns unknowns;
  std::vector<KernelTransducer> beacons, receivers;
  std::vector<std::vector<double>> gains;  ///< one for each pattern that is not a cone
  double reach_m = 0.0, amplitude_1m_v = 0.0, threshold_v = 0.0, absorption_np_per_m = 0.0;
  double constant_m2 = 0.0, per_m2 = 0.0, per_sqrt_m2 = 0.0;  ///< coefficients of the ranges' variance
};

/// Poses of one call, padded to kMapLanes beyond `count`, and the walls that may block their paths: walls
/// [wall_first[b], wall_first[b + 1]) belong to beacon b. `skip` is set for a beacon that no pose of the tile
/// receives.
struct KernelTile {
  std::size_t count = 0;
  alignas(64) double x_m[kTilePoses], y_m[kTilePoses], z_m[kTilePoses], cosine[kTilePoses], sine[kTilePoses];
  std::vector<KernelWall> walls;
  std::vector<std::uint32_t> wall_first;
  std::vector<std::uint8_t> skip;
};

struct KernelFigures {
  alignas(64) double value[kFigures][kTilePoses];
};

struct KernelWork {
  std::vector<double> of_beacon;  ///< scratch
  std::vector<std::uint8_t>
      heard_bits;  ///< out: bit i % 8 of byte b * kTilePoses / 8 + i / 8 is set if pose i receives beacon b
};

}  // namespace octant::survey
