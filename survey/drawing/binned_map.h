// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "survey/map/survey.h"

namespace octant::survey {

/// A map as a rectangle of plain numbers, for pictures and reports. Row 0 is the lowest. A bin holds the
/// worst of its cells.
struct BinnedMap {
  std::string name, title, unit;
  std::size_t columns = 0, rows = 0;
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  ///< lower left corner
  double bin_m = 0.25;
  enum class Bin : std::uint8_t { kOffFloor, kValue, kEmpty };  ///< kEmpty: no fix
  std::vector<Bin> bins;
  std::vector<double> values;  ///< values of kValue bins; 0 elsewhere
  bool low_is_bad = false;
  double low = 0.0, high = 1.0;  ///< range of the colours: 0 (or the least) to the limit or the 95 % quantile
  bool against_tolerance = false;  ///< high is the site's tolerance: the colours say inside, near, beyond
};

/// @param most  bins along the longer side; a whole number of cells makes a bin
[[nodiscard]] BinnedMap binned_map(const Survey& survey, const FloorMap& map, std::size_t most = 120);
/// One bin a cell.
[[nodiscard]] BinnedMap cell_map(const Survey& survey, const FloorMap& map);

/// Colour of a value, red, green, blue: against a tolerance green inside, amber near and red beyond
/// (palette.h); else from dark blue to yellow, which is no judgement, and stays yellow beyond the range. Grey
/// for no fix.
[[nodiscard]] std::array<std::uint8_t, 3> colour_of(const BinnedMap& map, std::size_t bin);

/// Pixels of one bin each, red, green, blue, opacity, from the top row down.
[[nodiscard]] std::vector<std::uint8_t> pixels_of(const BinnedMap& map);

/// Grey values of a costmap with one pixel a bin, row 0 the lowest: 254 the best, 1 at the range's end, 0
/// beyond or without a fix, 205 off the floor.
[[nodiscard]] std::vector<std::uint8_t> costs_of(const BinnedMap& map);

}  // namespace octant::survey
