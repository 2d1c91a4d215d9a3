// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/deployment.h"
#include "models/support/scratch.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// The noise of a deployment's arrivals with a bias of a pair that the site states and one that calibration
/// found as one.
[[nodiscard]] CorrelatedNoise correlated_noise(const Deployment& deployment);
/// Standard deviation of a single arrival: white, correlated and of its pair together [s].
[[nodiscard]] double single_arrival_sigma_s(const Deployment& deployment);

/// The sigmas of a segment's arrivals as weights of a least-squares estimate that counts them as independent.
/// With rho = exp(-dt / time_s) the errors of one pair are correlated, so that n of them say less than n;
/// each gets the variance
///   sigma^2 + sigma_s^2 (sum over the pair's others of rho) + pair_sigma_s^2 (number of the pair's others),
/// whose mean over n has the variance of the mean of the correlated ones where they see the state from the
/// same side. Along a drive the side changes; there a pair's lasting bias is counted by
/// `add_drive_calibration` and not here. Gates stay those of a single arrival.
class CorrelatedArrivals {
 public:
  enum class Side { kSame, kChanging };
  CorrelatedArrivals(Trajectory& trajectory, const Segment& segment, const CorrelatedNoise& noise, Side side);

  /// Sets the weights by the arrivals that are in use now.
  void weigh();
  /// Sets the sigmas of single arrivals again.
  void restore();

 private:
  Trajectory& trajectory_;
  Segment segment_;
  CorrelatedNoise noise_;
  Side side_;
  std::pmr::vector<double> single_s_{scratch()};
  std::pmr::vector<std::size_t> by_pair_{
      scratch()};  ///< arrivals, those of a pair together, in the order of time
};

}  // namespace octant
