// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/trajectory/shared_state.h"

namespace octant {

/// Directional receivers hear some way past the side, hardly from behind; where calibration has seen no more
/// of them.
inline constexpr double kHearingCosine = -0.2;

struct EpochFixOptions {
  /// Extra standard deviation of every predicted range, for beacons known only roughly [m].
  double range_uncertainty_m = 0.0;
  double rejection_sigmas = 4.0;
  /// Geometry is poor where a horizontal sigma (of a place in space: the largest) is beyond this, and beyond
  /// ten times that of a range.
  double max_sigma_m = 1.0;
  int max_candidates = 640;    ///< poses tried in the coarse search
  bool bounded_search = true;  ///< SearchOptions::bounded
  /// No search where it could find nothing better: linear ranges place a planar node in closed form, it is
  /// adjusted, and if then all arrivals but a few echoes agree, of three beacons and more that are not in
  /// line, over seven paths and more, and they tell the heading, that is the fix. Else the search starts
  /// where the linear ranges are, and looks only for poses that explain the arrivals as well (rivals.h).
  bool closed_form_first = false;
  /// A second pose counts as equally good when its log likelihood is within this of the best (3: odds below
  /// twenty to one).
  double ambiguity_margin = 2.0;
  /// Leaves out a beacon whose arrivals together contradict the others beyond chance (that of errors as the
  /// deployment states them: white, lasting, its calibration's), instead of giving the fix no protection
  /// level.
  bool exclude_faulty_beacons = true;
};

/// Everything the search has to know besides the arrivals.
struct EpochFixModel {
  SharedState state;
  std::vector<bool> beacon_usable;
  std::vector<std::optional<Eigen::Vector3d>> receiver_axis;
  std::vector<double>
      hearing_cosine;  ///< of each receiver, beyond which it hardly hears; empty: kHearingCosine for all
  double nominal_speed_mps = 343.0;
  /// Of each beacon's x, y, z [m], delay [s] and the speed [m/s]: how far calibration itself may be off.
  /// Empty: not at all.
  std::vector<Eigen::Matrix<double, 5, 5>> beacon_covariance;
  /// What the arrivals of a pair have in common beside the calibration (correlated_arrivals.h). Zero: each
  /// has its own error.
  CorrelatedNoise correlated{};
};
[[nodiscard]] EpochFixModel epoch_fix_model(const Deployment& deployment);

}  // namespace octant
