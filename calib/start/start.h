// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/problem/problem.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/shared_state.h"

namespace octant::calib {

/// Initial values of everything: shared parameters and vehicle states.
struct Start {
  SharedState state;
  std::vector<Trajectory> trajectories;  ///< nodes placed where a start was found
  std::vector<bool> beacon_found;        ///< position known well enough to begin with
  double uncertainty_m = 0.0;            ///< uncertainty of predicted ranges at the start
  std::vector<std::string> warnings;
};

/// Initial values from the data of the site and the runs, most direct first: approximate beacons, then
/// measured poses (beacons by trilateration). After that it alternates between vehicle states from the
/// beacons found so far and beacons from the states found so far.
[[nodiscard]] Start initial_values(const Problem& problem, int threads = 1);

/// Mirror image of a beacon's position that its ranges from the present states do not exclude, to scale_m; no
/// value if they do.
[[nodiscard]] std::optional<Eigen::Vector3d> mirror_image(const Problem& problem, const SharedState& state,
                                                          const std::vector<Trajectory>& trajectories,
                                                          std::size_t beacon, double scale_m);

/// Input of the epoch search, for the beacons marked usable.
[[nodiscard]] EpochFixModel search_model(const Problem& problem, const SharedState& state,
                                         const std::vector<bool>& usable);

/// Places the states of a trajectory without an initial value; with `again` also those of epochs with an
/// arrival beyond `suspect_sigmas`. States with a measured pose are unchanged. Returns the number of segments
/// placed again.
std::size_t place_states(Trajectory& trajectory, const EpochFixModel& model, double uncertainty_m, bool again,
                         double suspect_sigmas = 0.0, int threads = 1);

}  // namespace octant::calib
