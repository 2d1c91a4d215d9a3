// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calib/problem/parameters.h"
#include "models/deployment.h"
#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// What was heard of a beacon, or by a receiver.
struct Heard {
  std::string name;  ///< "B3", "robot/r0"
  std::size_t used = 0, late = 0, early = 0;
  double misfit_s = 0.0;  ///< median over its arrivals of observed less predicted, were it as the earlier
                          ///< calibration left it
};

/// Beacons of which nothing at all was heard, though those beside them were where it would have been:
/// switched off, covered or taken away. @return by name
[[nodiscard]] std::vector<std::string> silent_beacons(const Deployment& before,
                                                      const std::vector<Trajectory>& trajectories);
/// Receivers that took nothing while others of their vehicle did. @return by name, "robot/r0"
[[nodiscard]] std::vector<std::string> silent_receivers(const Deployment& before,
                                                        const std::vector<Trajectory>& trajectories);

/// Beacons that lost many of their arrivals, so that their places are in doubt; most doubtful first.
[[nodiscard]] std::vector<std::size_t> doubtful_beacons(const Deployment& before,
                                                        const std::vector<Trajectory>& trajectories);

/// Beacons that a visit of a planar vehicle found below its receivers and that hung above them, or the other
/// way round, are put to their image, which no arrival tells from there. @return whether there were any
[[nodiscard]] bool turn_to_known_side(const Deployment& before, const ParameterLayout& layout,
                                      Eigen::VectorXd& x);

/// What was heard of each beacon of the earlier deployment, or by each receiver. @param state  as a visit
/// found it
[[nodiscard]] std::vector<Heard> heard_of_beacons(const Deployment& before,
                                                  const std::vector<Trajectory>& trajectories,
                                                  const SharedState& state);
[[nodiscard]] std::vector<Heard> heard_by_receivers(const Deployment& before,
                                                    const std::vector<Trajectory>& trajectories,
                                                    const SharedState& state);

}  // namespace octant::calib
