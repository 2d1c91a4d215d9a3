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

/// Errors beyond this number of sigmas are treated as tails: normal ones exceed it once in 22 times.
inline constexpr double kTailSigmas = 2.0;
/// Smallest relative change of a sigma for which an adjustment is repeated.
inline constexpr double kTailChanged = 0.1;

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
  /// Widens the sigmas that weigh() begins with: an arrival whose residual exceeds two sigmas gets half of
  /// its residual as sigma, because reflections and antennas have heavier tails than a normal distribution.
  /// Its influence then decreases with its residual (a redescending M-estimator; Huber 1981, section 4.8).
  /// Normal errors lose 1.7 % of accuracy. Requires the sigmas of single arrivals; does nothing for white
  /// noise.
  /// @return true if a sigma has changed by more than a tenth
  bool widen_tails(const SharedState& state);
  /// Forgets what widen_tails() did.
  void narrow_tails();

 private:
  Trajectory& trajectory_;
  Segment segment_;
  CorrelatedNoise noise_;
  Side side_;
  std::pmr::vector<double> single_s_{scratch()}, tail_s_{scratch()};
  std::pmr::vector<std::size_t> by_pair_{
      scratch()};  ///< indices of arrivals, grouped by pair, in order of time
};

}  // namespace octant
