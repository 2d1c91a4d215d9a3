// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/network/solve_network.h"
#include "models/network/beacon_ranges.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::calib {

struct SolvedRangeNetwork {
  SolvedNetwork solved;
  /// Neither given positions nor heights tell the network from its mirror image.
  bool mirror_is_equal = false;
  std::vector<std::string> ambiguous;  ///< beacons left out: leave_out_ambiguous()
};

/// Positions of beacons from ranges between them alone, without a vehicle:
///   1. place_by_ranges(): shortest paths, multidimensional scaling, robust stress,
///   2. a rigid fit to positions that the site gives, which also decides between mirror images,
///   3. adjustment of the distances with a delay of each beacon (prior: timing.delay_sigma_s); coordinates
///   with
///      a sigma are observations, those with sigma 0 fixed, and inner constraints define the rest of the
///      datum,
///   4. ranges whose w-test fails are left out, the worst first (echoes), as long as each beacon keeps enough
///   of them,
///   5. the sigma of the ranges is scaled to their residuals,
///   6. beacons whose ranges fit another position equally well are left out.
/// Where the start of step 1 fails, others are tried.
/// The plane is enough to place points whose heights are all given.
/// Errors: kBadInput without enough ranges.
[[nodiscard]] Result<SolvedRangeNetwork> solve_range_network(const Site& site, const BeaconRanges& ranges);

}  // namespace octant::calib
