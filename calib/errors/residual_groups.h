// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace octant::calib {

/// Residuals of the used arrivals of one group.
struct ResidualGroup {
  std::string name;             ///< name of beacon or receiver; empty for a bin
  double from = 0.0, to = 0.0;  ///< ends of a bin: metres, radians, degrees Celsius or seconds
  std::size_t count = 0;
  double mean_s = 0.0, rms_s = 0.0;
  double mean_m = 0.0, rms_m = 0.0;
};

/// A residual and what it is grouped by.
struct GroupedResidual {
  double key = 0.0;  ///< index of a name, or the quantity that is binned
  double residual_s = 0.0;
  double speed_mps = 0.0;  ///< converts it to a range
};

/// One group for each name, empty ones included.
[[nodiscard]] std::vector<ResidualGroup> groups_by_name(const std::vector<GroupedResidual>& residuals,
                                                        const std::vector<std::string>& names);

/// Bins of equal counts (equal keys stay together), ascending.
/// @param bins  maximum number of bins; fewer if there are not 20 residuals for each
[[nodiscard]] std::vector<ResidualGroup> groups_by_quantity(std::vector<GroupedResidual> residuals,
                                                            std::size_t bins = 8);

}  // namespace octant::calib
