// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/trajectory/shared_state.h"

namespace octant {

/// Default cosine limit of directional receivers, which receive slightly beyond the side but hardly from
/// behind. Calibration may find a narrower one.
inline constexpr double kHearingCosine = -0.2;

struct EpochFixOptions {
  /// Additional sigma of every range, for roughly known beacons [m].
  double range_uncertainty_m = 0.0;
  double rejection_sigmas = 4.0;
  /// Geometry is poor if a horizontal sigma (for a position in space: the largest) exceeds this, and ten
  /// times that of a range.
  double max_sigma_m = 1.0;
  int max_candidates = 640;    ///< number of poses tried in the coarse search
  bool bounded_search = true;  ///< SearchOptions::bounded
  /// Avoids the search if it cannot find a better pose. Linear ranges give a planar node in closed form,
  /// which is adjusted. That is the fix if all arrivals except a few echoes agree, on seven or more paths
  /// from three or more beacons that are not collinear, and the heading is determined. Otherwise the search
  /// starts from the linear ranges and looks only for poses that explain the arrivals equally well
  /// (rivals.h).
  bool closed_form_first = false;
  /// A second pose is equally good if its log likelihood is within this margin of the best (3: odds below
  /// twenty to one).
  double ambiguity_margin = 2.0;
  /// Excludes a beacon whose arrivals together contradict the others significantly, given white, lasting and
  /// calibration errors of the deployment. Otherwise the fix has no protection level.
  bool exclude_faulty_beacons = true;
};

/// Model of the arrivals for the search.
struct EpochFixModel {
  SharedState state;
  std::vector<bool> beacon_usable;
  std::vector<std::optional<Eigen::Vector3d>> receiver_axis;
  std::vector<double> hearing_cosine;  ///< limit for each receiver; empty: kHearingCosine for all
  double nominal_speed_mps = 343.0;
  /// Calibration covariance of each beacon's x, y, z [m], delay [s] and the speed [m/s]. Empty: exact.
  std::vector<Eigen::Matrix<double, 5, 5>> beacon_covariance;
  /// Correlated noise of a pair's arrivals in addition to the calibration (correlated_arrivals.h). Zero:
  /// independent arrivals.
  CorrelatedNoise correlated{};
};
[[nodiscard]] EpochFixModel epoch_fix_model(const Deployment& deployment);

}  // namespace octant
