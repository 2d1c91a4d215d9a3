// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/errors/reliability.h"

namespace octant::calib {

/// A residual and what it is grouped by.
struct GroupedResidual {
  double key = 0.0;  ///< index of a name, or the quantity that is binned
  double residual_s = 0.0;
  double speed_mps = 0.0;  ///< turns it into a range
};

/// One group for each name, empty ones included.
[[nodiscard]] std::vector<ResidualGroup> groups_by_name(const std::vector<GroupedResidual>& residuals,
                                                        const std::vector<std::string>& names);

/// Bins of equal counts (equal keys stay together), ascending.
/// @param bins  at most; fewer where there are not 20 residuals for each
[[nodiscard]] std::vector<ResidualGroup> groups_by_quantity(std::vector<GroupedResidual> residuals,
                                                            std::size_t bins = 8);

}  // namespace octant::calib
