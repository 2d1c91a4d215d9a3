// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "models/ids.h"
#include "models/run.h"
#include "models/site.h"

namespace octant {

/// One measured time of flight between two beacons.
struct BeaconFlight {
  double time_s = 0.0;
  BeaconId from, to;
  double tof_s = 0.0;
  std::size_t run = 0;  ///< number of its recording
};

/// Time of flight between two beacons, in both directions and all recordings.
struct BeaconRange {
  BeaconId from, to;
  std::size_t run = 0;           ///< first recording that has it
  double model_speed_mps = 1.0;  ///< speed there by the medium's model
  double tof_s = 0.0;            ///< without turnaround and mean delay
  double sigma_s = 0.0;          ///< of the mean; a bias of the pair does not average out
  std::size_t used = 0, left_out = 0;
};

/// Ranges between beacons. In them each beacon has a delay of its own with mean zero, which differs from its
/// delay in arrivals. The delays are eliminated: the covariance of the ranges is
/// C = diag(sigma^2) + delay_sigma^2 B B^T, where B has a one for both beacons of a range.
struct BeaconRanges {
  std::vector<BeaconRange> pairs;
  double delay_sigma_s = 0.0;
  Eigen::MatrixXd root;  ///< lower triangular, root^T root = C^-1

  [[nodiscard]] Eigen::MatrixXd covariance(double delay_sigma_s) const;
  void set_delay_sigma(double sigma_s);
};

/// Combines the rows of all recordings by the mean of the times that agree with the median of their pair. The
/// bias of a pair and the delays of the beacons have the sigma of a single range (noise.tof_sigma_s, and
/// noise.pair_sigma_s where it is given) until residuals show larger ones.
/// @param runs  recordings, for their temperatures; may be empty
[[nodiscard]] BeaconRanges beacon_ranges(const Site& site, const std::vector<BeaconFlight>& flights,
                                         const std::vector<MeasurementLog>& runs = {});

}  // namespace octant
