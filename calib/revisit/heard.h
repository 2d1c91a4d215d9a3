// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calib/problem/parameters.h"
#include "models/changes/reception.h"
#include "models/deployment.h"
#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Arrivals from a beacon, or at a receiver.
struct Heard {
  std::string name;  ///< "B3", "robot/r0"
  std::size_t used = 0, late = 0, early = 0;
  double misfit_s = 0.0;  ///< median of observed minus predicted time for the earlier calibration
  Reception reception;    ///< arrivals received and expected
};

/// Beacons and receivers that were received far less than expected.
[[nodiscard]] std::vector<Silence> silent_of(const std::vector<Heard>& beacons,
                                             const std::vector<Heard>& receivers);
/// Beacons without any arrival that are not silent: out of reach along this path.
[[nodiscard]] std::vector<std::string> not_observed_of(const Deployment& before,
                                                       const std::vector<Heard>& beacons);

/// Beacons that lost many of their arrivals, so that their positions are in doubt; most doubtful first.
[[nodiscard]] std::vector<std::size_t> doubtful_beacons(const Deployment& before,
                                                        const std::vector<Trajectory>& trajectories);

/// Moves beacons to their mirror image if a planar visit found them on the other side of the receivers' plane
/// than before; arrivals do not distinguish the two.
/// @return true if there were any
[[nodiscard]] bool turn_to_known_side(const Deployment& before, const ParameterLayout& layout,
                                      Eigen::VectorXd& x);

/// Arrivals from each beacon of the earlier deployment, or at each receiver.
/// @param state  state found by the visit
[[nodiscard]] std::vector<Heard> heard_of_beacons(const Deployment& before,
                                                  const std::vector<Trajectory>& trajectories,
                                                  const SharedState& state);
[[nodiscard]] std::vector<Heard> heard_by_receivers(const Deployment& before,
                                                    const std::vector<Trajectory>& trajectories,
                                                    const SharedState& state);

}  // namespace octant::calib
