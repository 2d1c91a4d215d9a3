// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/problem/parameters.h"

namespace octant::calib {

/// What was found wrong with the site file's positions, and the priors as mended.
struct LabelCheck {
  bool mended = false;                   ///< priors of the layout were changed: adjust again
  std::vector<std::string> warnings;     ///< name the beacons
  std::vector<std::size_t> disregarded;  ///< beacons that lost their priors
};

/// Compares where the arrivals put each beacon with where the site file has it. Two beacons at each other's
/// places were exchanged: their priors are exchanged. One that is far from its place (beyond six sigmas)
/// without such a partner loses its prior, unless it is one of those to be trusted. Both are told by name.
[[nodiscard]] LabelCheck check_labels(const Problem& problem, ParameterLayout& layout,
                                      const Eigen::VectorXd& x, const std::vector<std::size_t>& trusted = {});

/// Control points cannot move: one whose arrivals are mostly rejected is located from the vehicle states by
/// its own ranges, and told where it really seems to be, by the name of the beacon that the site file has
/// there.
[[nodiscard]] std::vector<std::string> suspect_control_points(const Problem& problem,
                                                              const SharedState& state,
                                                              const std::vector<Trajectory>& trajectories);

}  // namespace octant::calib
