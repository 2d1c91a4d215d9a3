// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/geometry_map.h"

#include <algorithm>
#include <memory>

#include "models/support/parallel.h"
#include "survey/geometry/layer_sigma.h"
#include "survey/geometry/map_tiles.h"

namespace octant::survey {
namespace {

/// Tiles that a thread takes at once, so that it needs few scratch pads.
constexpr std::size_t kTilesAtOnce = 16;

/// Calls work(tile, first) for each tile of the poses, on threads; every call of one stretch has the same
/// scratch.
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

struct FigureList {
  Figure figure;
  std::vector<double> GeometryFigures::*list;
  bool integrity = false;
};
constexpr FigureList kFigureLists[] = {{kHdop, &GeometryFigures::hdop},
                                       {kVdop, &GeometryFigures::vdop},
                                       {kPdop, &GeometryFigures::pdop},
                                       {kTdop, &GeometryFigures::tdop},
                                       {kGdop, &GeometryFigures::gdop},
                                       {kHeadingDop, &GeometryFigures::heading_dop_rad_per_m},
                                       {kSigma, &GeometryFigures::sigma_m},
                                       {kSigmaX, &GeometryFigures::sigma_x_m},
                                       {kSigmaY, &GeometryFigures::sigma_y_m},
                                       {kSigmaZ, &GeometryFigures::sigma_z_m},
                                       {kSigmaHeading, &GeometryFigures::sigma_heading_rad},
                                       {kShiftBySpeed, &GeometryFigures::shift_by_speed_m},
                                       {kCovarianceXy, &GeometryFigures::covariance_xy_m2},
                                       {kDetectableBias, &GeometryFigures::detectable_bias_m, true},
                                       {kFaultShift, &GeometryFigures::fault_shift_m, true},
                                       {kProtection, &GeometryFigures::protection_m, true}};

}  // namespace

GeometryFigures evaluate_poses(const SurveyModel& model, const PoseList& poses, const MapOptions& options) {
  const KernelModel kernel = kernel_model(model, model.beacons);
  GeometryFigures out;
  for (const FigureList& f : kFigureLists)
    if (options.integrity || !f.integrity) (out.*f.list).resize(poses.size());
  out.beacons.resize(poses.size());
  out.arrivals.resize(poses.size());
  for_each_tile<MapScratch>(
      kernel, model.walls, poses, options.threads,
      [&](const KernelTile& tile, std::size_t first, MapScratch& scratch) {
        map_tile(kernel, tile, options.integrity, scratch.work, scratch.figures);
        const auto offset = static_cast<std::ptrdiff_t>(first);
        for (const FigureList& f : kFigureLists) {
          if (!options.integrity && f.integrity) continue;
          const double* values = scratch.figures.value[f.figure];
          std::copy(values, values + tile.count, (out.*f.list).begin() + offset);
        }
        for (std::size_t i = 0; i < tile.count; ++i) {
          out.beacons[first + i] = static_cast<std::uint16_t>(scratch.figures.value[kBeacons][i]);
          out.arrivals[first + i] = static_cast<std::uint16_t>(scratch.figures.value[kArrivals][i]);
        }
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
