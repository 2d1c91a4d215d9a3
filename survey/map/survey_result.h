// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "models/scene.h"
#include "survey/geometry/geometry_figures.h"
#include "survey/geometry/survey_model.h"
#include "survey/map/floor_grid.h"
#include "survey/map/losses.h"

namespace octant::survey {

struct SurveyOptions {
  int threads = 1;
  int failures = 2;       ///< number of beacons that may fail at the same time: 0, 1 or 2 (up to 300 beacons)
  bool integrity = true;  ///< detectable biases, protection levels, mirror images
};

/// Over the cells (or poses of a route) that have a value.
struct Spread {
  double min = 0.0, median = 0.0, p95 = 0.0, max = 0.0;
  std::size_t count = 0;    ///< cells with a value
  std::size_t without = 0;  ///< cells without: no fix
};
[[nodiscard]] Spread spread_of(std::vector<float> values);

/// One figure over the floor. Values go with FloorGrid::cells; infinity: no fix there.
struct FloorMap {
  std::string name;   ///< for machines: "sigma_m"
  std::string title;  ///< for people: "expected standard deviation"
  std::string unit;   ///< "m", "rad", "" for plain numbers
  bool low_is_bad = false;
  std::optional<double> limit;  ///< limit beyond which (below, if low values are bad) a cell does not pass
  std::vector<float> values;
  Spread spread;
};

struct RouteSurvey {
  std::string name;
  PoseList poses;
  std::vector<std::vector<std::uint8_t>> heard_bits;  ///< as of Survey
  std::vector<FloorMap> maps;  ///< the quantities of the floor along the poses, without failures
  double covered_fraction = 0.0;
};

/// Quality of a geometry.
struct Survey {
  SurveyModel model;
  Scene scene;
  FloorGrid grid;
  std::vector<FloorMap> maps;
  std::vector<RouteSurvey> routes;
  double fix_fraction = 0.0;  ///< fraction of cells with a fix
  /// With a fix within tolerance.fix_m (noise and calibration; without a tolerance: with a fix) that is not
  /// one of two places.
  double covered_fraction = 0.0;
  double k_covered_fraction = 0.0;  ///< fraction of cells that receive `coverage` beacons or more
  int coverage = 0;
  double mirror_fraction =
      0.0;  ///< fraction of cells with a fix whose mirror image explains the ranges as well
  std::vector<double> heard_fraction;                 ///< for each beacon, fraction of cells that receive it
  std::vector<std::vector<std::uint8_t>> heard_bits;  ///< for each beacon: bit i % 8 of byte i / 8 for cell i
  std::vector<Loss> failures, double_failures;
  std::optional<double> temperature_error_degC;  ///< error of temperature in the what-if; no value if the
                                                 ///< medium's speed does not depend on it
  double speed_error = 0.0;                      ///< relative error of distances that goes with it
  bool calibrated = false;                       ///< the calibration's part is known

  /// Cells times headings.
  [[nodiscard]] std::size_t poses() const {
    return grid.cells.size() * static_cast<std::size_t>(scene.headings);
  }
  [[nodiscard]] const FloorMap* find(const std::string& name) const;
  /// Returns true if beacon b is received in the i-th cell of the grid (at any of the headings).
  [[nodiscard]] bool hears(std::size_t b, std::size_t i) const {
    return ((heard_bits[b][i / 8] >> (i % 8)) & 1) != 0;
  }
};

}  // namespace octant::survey
