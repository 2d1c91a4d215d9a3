// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "survey/geometry/quantity.h"

namespace octant::survey {

/// Residuals of one bin, or of one beacon.
struct ResidualBin {
  std::string name;  ///< empty for a bin
  double from = 0.0, to = 0.0;
  std::size_t count = 0;
  double mean_s = 0.0, rms_s = 0.0;
};

/// Residuals by some quantity, binned: a report never carries single arrivals.
struct ResidualChart {
  std::string by;    ///< "beacon", "distance", ...
  std::string unit;  ///< unit of the bins' ends: "m", "deg", "degC", "s"; empty for names
  std::vector<ResidualBin> bins;
  /// In which its residuals are read with ease.
  [[nodiscard]] Unit time() const {
    double largest_s = 0.0;
    for (const ResidualBin& bin : bins) largest_s = std::max(largest_s, bin.rms_s);
    return time_unit(largest_s);
  }
};

/// Standardised residuals counted in bins of equal width; what lies beyond the ends is in the outermost bins.
struct Histogram {
  double from = 0.0, width = 0.0;
  std::vector<std::size_t> counts;
};

}  // namespace octant::survey
