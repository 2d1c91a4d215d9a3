// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "calib/solution/solve_options.h"

namespace octant::calib {

/// Result of an adjustment under a hypothesis.
struct ReadingScore {
  double loss = 0.0;  ///< negative log-likelihood per arrival: Gaussian if it agrees, constant if it does not
  double agreeing = 0.0;    ///< share of arrivals that agree
  double noise = INFINITY;  ///< noise of those relative to the site file
  double redundancy = 0.0;  ///< redundancy per arrival
  double arrivals = 0.0;
  std::size_t disregarded = 0;     ///< beacons whose positions in the site file were ignored
  double delay_s = 0.0;            ///< delay of an arrival, mean over beacons and receivers
  std::vector<double> sizes = {};  ///< sizes of the residuals, in sigmas of the site file
  std::vector<Eigen::Vector3d> beacon_p_map_m = {}, receiver_p_vehicle_m = {};
};

/// Size of the part of the recordings that is adjusted.
struct LogShare {
  std::size_t instants, per_beacon, drive_arrivals, stretches;
};
/// An evenly spread part of each run.
[[nodiscard]] std::vector<MeasurementLog> few_of(const std::vector<MeasurementLog>& runs, const Site& site,
                                                 const LogShare& share);

/// Quick calibration: robust initialisation, rejection at four sigmas, least squares. An arrival that does
/// not agree costs as much as one at the limit, and so does a beacon whose position has to be ignored.
/// @param search_again  see approach (start/approach.h)
[[nodiscard]] ReadingScore score_of(const Site& site, const std::vector<MeasurementLog>& runs,
                                    const SolveOptions& options, bool search_again);

}  // namespace octant::calib
