// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/problem/parameters.h"

namespace octant::calib {

/// Faults of the site file's positions, and the corrected priors.
struct LabelCheck {
  bool mended = false;                   ///< priors of the layout were changed: adjust again
  std::vector<std::string> warnings;     ///< name the beacons
  std::vector<std::size_t> disregarded;  ///< beacons that lost their priors
};

/// Compares the estimated position of each beacon with the site file. If two beacons are at each other's
/// positions, they were exchanged, and so are their priors. A beacon far from its position (beyond six
/// sigmas) without such a partner loses its prior, unless it is to be trusted. Both are reported by name.
[[nodiscard]] LabelCheck check_labels(const Problem& problem, ParameterLayout& layout,
                                      const Eigen::VectorXd& x, const std::vector<std::size_t>& trusted = {});

/// Control points cannot move. One whose arrivals are mostly rejected is located from the vehicle states by
/// its own ranges, and its apparent position is reported, with the name of the beacon that the site file has
/// there.
[[nodiscard]] std::vector<std::string> suspect_control_points(const Problem& problem,
                                                              const SharedState& state,
                                                              const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
