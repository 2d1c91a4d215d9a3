// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/geometry_map.h"

#include <algorithm>
#include <memory>

#include "models/support/parallel.h"
#include "survey/geometry/layer_sigma.h"
#include "survey/geometry/map_kernel.h"
#include "survey/geometry/map_tiles.h"

namespace octant::survey {
namespace {

/// Tiles that a thread takes at once, so that it needs few scratch pads.
constexpr std::size_t kTilesAtOnce = 16;

/// Calls work(tile, first) for each tile of the poses, on several threads. Calls of one block of tiles share
/// their scratch memory.
template <class Scratch, class Work>
void for_each_tile(const KernelModel& kernel, const std::vector<WallPiece>& walls, const PoseList& poses,
                   int threads, Work&& work) {
  const std::size_t tiles = (poses.size() + kTilePoses - 1) / kTilePoses;
  for_each_parallel((tiles + kTilesAtOnce - 1) / kTilesAtOnce, threads, [&](std::size_t stretch) {
    const auto tile = std::make_unique<KernelTile>();
    const auto scratch = std::make_unique<Scratch>();
    for (std::size_t t = stretch * kTilesAtOnce; t < std::min(tiles, (stretch + 1) * kTilesAtOnce); ++t) {
      const std::size_t first = t * kTilePoses;
      fill_tile(kernel, walls, poses, first, std::min(kTilePoses, poses.size() - first), *tile);
      work(*tile, first, *scratch);
    }
  });
}

struct MapScratch {
  KernelWork work;
  KernelFigures figures;
};

struct LayerScratch {
  alignas(64) double information[28 * kTilePoses];
  alignas(64) double heard[kTilePoses];
};

/// Integrity, which needs most of the time.
bool is_integrity(std::size_t figure) {
  return figure == kDetectableBias || figure == kFaultShift || figure == kProtection;
}

}  // namespace

GeometryFigures evaluate_poses(const SurveyModel& model, const PoseList& poses, const MapOptions& options) {
  const KernelModel kernel = kernel_model(model, model.beacons);
  GeometryFigures out;
  const auto asked = [&](std::size_t f) { return options.integrity || !is_integrity(f); };
  for (std::size_t f = 0; f < kFigures; ++f)
    if (asked(f)) out[f].resize(poses.size());
  for_each_tile<MapScratch>(kernel, model.walls, poses, options.threads,
                            [&](const KernelTile& tile, std::size_t first, MapScratch& scratch) {
                              map_tile(kernel, tile, options.integrity, scratch.work, scratch.figures);
                              for (std::size_t f = 0; f < kFigures; ++f)
                                if (asked(f))
                                  std::copy_n(scratch.figures.value[f], tile.count,
                                              out[f].begin() + static_cast<std::ptrdiff_t>(first));
                            });
  return out;
}

BeaconLayer beacon_layer(const SurveyModel& model, const SurveyBeacon& beacon, const PoseList& poses,
                         int threads) {
  const KernelModel kernel = kernel_model(model, {beacon});
  const auto entries = static_cast<std::size_t>(model.unknowns.entries());
  BeaconLayer layer{std::vector<double>(entries * poses.size()), std::vector<std::uint8_t>(poses.size())};
  for_each_tile<LayerScratch>(
      kernel, model.walls, poses, threads,
      [&](const KernelTile& tile, std::size_t first, LayerScratch& scratch) {
        layer_tile(kernel, tile, 0, scratch.information, scratch.heard);
        for (std::size_t e = 0; e < entries; ++e)
          std::copy_n(scratch.information + e * kTilePoses, tile.count,
                      layer.information.begin() + static_cast<std::ptrdiff_t>(e * poses.size() + first));
        for (std::size_t i = 0; i < tile.count; ++i) layer.heard[first + i] = scratch.heard[i] > 0;
      });
  return layer;
}

std::vector<std::vector<std::uint8_t>> heard_at(const SurveyModel& model, const PoseList& poses,
                                                int threads) {
  const KernelModel kernel = kernel_model(model, model.beacons);
  std::vector<std::vector<std::uint8_t>> heard(model.beacons.size(), std::vector<std::uint8_t>(poses.size()));
  for_each_tile<LayerScratch>(kernel, model.walls, poses, threads,
                              [&](const KernelTile& tile, std::size_t first, LayerScratch& scratch) {
                                for (std::size_t b = 0; b < heard.size(); ++b) {
                                  layer_tile(kernel, tile, b, scratch.information, scratch.heard);
                                  for (std::size_t i = 0; i < tile.count; ++i)
                                    heard[b][first + i] = scratch.heard[i] > 0;
                                }
                              });
  return heard;
}

void sigma_of_information(const Unknowns& unknowns, std::span<const double> information,
                          std::span<double> sigma_m) {
  sigma_of_packed(unknowns.count(), information.data(), nullptr, nullptr, sigma_m.size(), sigma_m.size(),
                  sigma_m.data());
}

}  // namespace octant::survey
