// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/adjust/estimate.h"
#include "calib/problem/trilaterate.h"

namespace octant::calib {

/// A beacon's place and delay: x, y, z [m], and by how much its delay lengthens a range [m].
using PlaceAndDelay = Eigen::Vector4d;

/// Prior of a beacon's position and delay.
struct PlacePrior {
  PlaceAndDelay mean = PlaceAndDelay::Zero();
  PlaceAndDelay sigma = PlaceAndDelay::Constant(INFINITY);  ///< infinite: no prior; 0: fixed
};

/// The place and delay that the largest consensus of ranges from known places agrees on: the least that is
/// found of half the squares, each up to that of the rejection, and the prior's. A beacon behind an obstacle
/// for half of the recording fits its direct arrivals at one place, and at another, some tens of centimetres
/// off, some of the direct and some of the late ones; a descent from there does not get out. So it is
/// descended from a grid of places about the start, under a loss whose scale goes from a third of the grid's
/// spacing down to the noise (graduated non-convexity with Geman and McClure's loss: Yang, Antonante,
/// Tzoumas, Carlone 2020). Deterministic.
/// @param ranges  late ones may be as many as the direct ones  @param start  where the beacon is now
/// @param sigma_m  of a range
/// @return nothing where no place is better than the start by half a square of the rejection
[[nodiscard]] std::optional<PlaceAndDelay> place_of_largest_consensus(const std::vector<RangeFrom>& ranges,
                                                                      const PlacePrior& prior,
                                                                      const PlaceAndDelay& start,
                                                                      double sigma_m,
                                                                      double rejection_sigmas);

/// Free beacons with many arrivals at placed states beyond `rejection_sigmas`, and more than others have; the
/// worst first, eight at most.
[[nodiscard]] std::vector<std::size_t> beacons_that_do_not_fit(const AdjustedLog& log,
                                                               double rejection_sigmas);

/// The parameters with a beacon moved to place_of_largest_consensus() for the present states. No value if it
/// is there already.
[[nodiscard]] std::optional<Eigen::VectorXd> with_beacon_of_larger_consensus(const Problem& problem,
                                                                             const AdjustedLog& log,
                                                                             std::size_t beacon,
                                                                             double rejection_sigmas);

}  // namespace octant::calib
