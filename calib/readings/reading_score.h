// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "calib/solution/solve_options.h"

namespace octant::calib {

/// What an adjustment makes of a reading.
struct ReadingScore {
  double loss =
      0.0;  ///< negative log likelihood an arrival: Gauss where it agrees, a constant where it does not
  double agreeing = 0.0;    ///< share of the arrivals
  double noise = INFINITY;  ///< of those, over the stated one
  double redundancy = 0.0;  ///< an arrival
  double arrivals = 0.0;
  std::size_t disregarded = 0;     ///< beacons whose stated places were not believed
  double delay_s = 0.0;            ///< of an arrival, mean over beacons and receivers
  std::vector<double> sizes = {};  ///< of the residuals, in stated sigmas
  std::vector<Eigen::Vector3d> beacon_p_map_m = {}, receiver_p_vehicle_m = {};
};

/// How much of the recordings is adjusted.
struct LogShare {
  std::size_t instants, per_beacon, drive_arrivals, stretches;
};
/// An evenly spread part of each run.
[[nodiscard]] std::vector<MeasurementLog> few_of(const std::vector<MeasurementLog>& runs, const Site& site,
                                                 const LogShare& share);

/// A quick calibration: approach, rejection at four sigmas, plain squares. An arrival that does not agree
/// costs as much as one at the limit, and so does a beacon whose stated place has to be disregarded.
/// @param search_again  as approach (start/approach.h) has it
[[nodiscard]] ReadingScore score_of(const Site& site, const std::vector<MeasurementLog>& runs,
                                    const SolveOptions& options, bool search_again);

}  // namespace octant::calib
