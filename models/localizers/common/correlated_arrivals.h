// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/deployment.h"
#include "models/support/scratch.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Correlated noise of a deployment's arrivals. The constant bias of a pair combines the value of the site
/// file with that found by calibration.
[[nodiscard]] CorrelatedNoise correlated_noise(const Deployment& deployment);
/// Standard deviation of a single arrival: white and correlated noise and the bias of its pair [s].
[[nodiscard]] double single_arrival_sigma_s(const Deployment& deployment);

/// Sigmas for a least-squares estimate that treats correlated arrivals as independent. The errors of one pair
/// are correlated with rho = exp(-dt / time_s), so n of them carry less information than n independent ones.
/// Each gets the variance
///   sigma^2 + sigma_s^2 (sum over the pair's others of rho) + pair_sigma_s^2 (number of the pair's others)
/// The mean of n such arrivals has the variance of the mean of the correlated ones if they observe the state
/// from the same side. Along a drive the side changes; there `add_drive_calibration` accounts for a pair's
/// constant bias, not this class. Gates use the sigma of a single arrival.
class CorrelatedArrivals {
 public:
  enum class Side { kSame, kChanging };
  CorrelatedArrivals(Trajectory& trajectory, const Segment& segment, const CorrelatedNoise& noise, Side side);

  /// Sets the sigmas for the arrivals that are currently in use.
  void weigh();
  /// Restores the sigmas of single arrivals.
  void restore();

 private:
  Trajectory& trajectory_;
  Segment segment_;
  CorrelatedNoise noise_;
  Side side_;
  std::pmr::vector<double> single_s_{scratch()};
  std::pmr::vector<std::size_t> by_pair_{
      scratch()};  ///< indices of arrivals, grouped by pair, in order of time
};

}  // namespace octant
