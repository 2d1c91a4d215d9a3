// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/binned_map.h"

#include <algorithm>
#include <cmath>

#include "survey/drawing/palette.h"

namespace octant::survey {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

constexpr Rgb kGrey = {120, 120, 120};

void set_range(const FloorMap& map, BinnedMap& binned) {
  binned.low = 0.0;
  binned.against_tolerance = map.limit && *map.limit > 0;
  binned.high = map.limit.value_or(map.spread.p95);
  if (map.name == "beacons_heard") binned.high = map.spread.max;
  if (map.name == "loss_one_beacon") binned.low = -1, binned.high = map.spread.max;
  if (!(binned.high > binned.low)) binned.high = binned.low + 1.0;
}

BinnedMap bin(const Survey& survey, const FloorMap& map, std::size_t by) {
  const FloorGrid& grid = survey.grid;
  BinnedMap binned;
  binned.name = map.name, binned.title = map.title, binned.unit = map.unit,
  binned.low_is_bad = map.low_is_bad;
  binned.columns = (grid.columns + by - 1) / by, binned.rows = (grid.rows + by - 1) / by;
  binned.origin_m = grid.origin_m;
  binned.bin_m = grid.cell_m * static_cast<double>(by);
  binned.bins.assign(binned.columns * binned.rows, BinnedMap::Bin::kOffFloor);
  binned.values.assign(binned.bins.size(), 0.0);
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    const std::size_t at =
        grid.cells[i] / grid.columns / by * binned.columns + grid.cells[i] % grid.columns / by;
    const auto value = static_cast<double>(map.values[i]);
    BinnedMap::Bin& kind = binned.bins[at];
    if (std::isinf(value)) {
      kind = BinnedMap::Bin::kEmpty, binned.values[at] = 0.0;
    } else if (kind == BinnedMap::Bin::kOffFloor ||
               (kind == BinnedMap::Bin::kValue &&
                (map.low_is_bad ? value < binned.values[at] : value > binned.values[at]))) {
      kind = BinnedMap::Bin::kValue, binned.values[at] = value;
    }
  }
  set_range(map, binned);
  return binned;
}

}  // namespace

BinnedMap binned_map(const Survey& survey, const FloorMap& map, std::size_t most) {
  const std::size_t longer = std::max(survey.grid.columns, survey.grid.rows);
  return bin(survey, map, std::max<std::size_t>(1, (longer + most - 1) / most));
}

BinnedMap cell_map(const Survey& survey, const FloorMap& map) { return bin(survey, map, 1); }

Rgb colour_of(const BinnedMap& map, std::size_t at) {
  if (map.bins[at] == BinnedMap::Bin::kEmpty) return kGrey;
  const double part = (map.values[at] - map.low) / (map.high - map.low);
  if (map.against_tolerance) {
    const auto end = std::ranges::upper_bound(kToleranceParts, part);
    return rgb_of(kToleranceColours[static_cast<std::size_t>(end - kToleranceParts.begin())]);
  }
  constexpr std::size_t kLast = kMapColours.size() - 1;
  const double place = std::clamp(part, 0.0, 1.0) * static_cast<double>(kLast);
  const auto k = std::min(kLast - 1, static_cast<std::size_t>(place));
  const Rgb from = rgb_of(kMapColours[k]), to = rgb_of(kMapColours[k + 1]);
  Rgb colour;
  for (std::size_t i = 0; i < 3; ++i)
    colour[i] = static_cast<std::uint8_t>(
        std::lround(from[i] + (place - static_cast<double>(k)) * (to[i] - from[i])));
  return colour;
}

std::vector<std::uint8_t> pixels_of(const BinnedMap& map) {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(4 * map.bins.size());
  for (std::size_t row = map.rows; row-- > 0;)
    for (std::size_t column = 0; column < map.columns; ++column) {
      const std::size_t at = row * map.columns + column;
      const bool floor = map.bins[at] != BinnedMap::Bin::kOffFloor;
      const Rgb colour = floor ? colour_of(map, at) : Rgb{255, 255, 255};
      pixels.insert(pixels.end(), colour.begin(), colour.end());
      pixels.push_back(floor ? 255 : 0);
    }
  return pixels;
}

std::vector<std::uint8_t> costs_of(const BinnedMap& map) {
  std::vector<std::uint8_t> costs(map.bins.size(), 205);
  for (std::size_t at = 0; at < costs.size(); ++at) {
    if (map.bins[at] == BinnedMap::Bin::kEmpty) costs[at] = 0;
    if (map.bins[at] != BinnedMap::Bin::kValue) continue;
    double part = (map.values[at] - map.low) / (map.high - map.low);
    if (map.low_is_bad) part = 1 - part;
    costs[at] = part > 1 ? 0 : static_cast<std::uint8_t>(std::lround(254 - 253 * std::max(part, 0.0)));
  }
  return costs;
}

}  // namespace octant::survey
