// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/adjust/estimate.h"
#include "calib/problem/trilaterate.h"

namespace octant::calib {

/// Position and delay of a beacon: x, y, z [m], and delay as a range [m].
using PlaceAndDelay = Eigen::Vector4d;

/// Prior of a beacon's position and delay.
struct PlacePrior {
  PlaceAndDelay mean = PlaceAndDelay::Zero();
  PlaceAndDelay sigma = PlaceAndDelay::Constant(INFINITY);  ///< infinite: no prior; 0: fixed
};

/// Position and delay with which the largest consensus of ranges from known positions agrees. It minimises
/// half the squares, each limited to the rejection limit, and the prior.
///
/// A beacon behind an obstacle for half of the recording agrees with its direct arrivals at one position, and
/// some tens of centimetres away with some direct and some late ones, which is a local minimum. The search
/// therefore descends from a grid of positions about the start, under a loss whose scale decreases from a
/// third of the grid's spacing to the noise (graduated non-convexity with Geman and McClure's loss: Yang,
/// Antonante, Tzoumas, Carlone 2020). Deterministic.
/// @param ranges  may have as many late ones as direct ones
/// @param start  present position of the beacon
/// @param sigma_m  sigma of a range
/// @return no value if no position is better than the start by half a square of the rejection limit
[[nodiscard]] std::optional<PlaceAndDelay> place_of_largest_consensus(const std::vector<RangeFrom>& ranges,
                                                                      const PlacePrior& prior,
                                                                      const PlaceAndDelay& start,
                                                                      double sigma_m,
                                                                      double rejection_sigmas);

/// Free beacons with many arrivals beyond `rejection_sigmas`, and more than other beacons; worst first, at
/// most eight.
[[nodiscard]] std::vector<std::size_t> beacons_that_do_not_fit(const AdjustedLog& log,
                                                               double rejection_sigmas);

/// Returns the parameters with a beacon moved to place_of_largest_consensus() for the present states. No
/// value if it is there already.
[[nodiscard]] std::optional<Eigen::VectorXd> with_beacon_of_larger_consensus(const Problem& problem,
                                                                             const AdjustedLog& log,
                                                                             std::size_t beacon,
                                                                             double rejection_sigmas);

}  // namespace octant::calib
