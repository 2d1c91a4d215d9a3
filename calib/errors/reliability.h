// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/adjust/covariance.h"
#include "calib/errors/residual_groups.h"
#include "calib/problem/log_totals.h"
#include "calib/problem/parameters.h"
#include "models/deployment.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Critical value of Baarda's w at a significance of 0.1 %, two-sided.
inline constexpr double kCriticalW = 3.29;
/// Non-centrality at which a bias in one observation is found at that significance with a power of 80 %: 3.29
/// + 0.84.
inline constexpr double kDelta0 = 4.13;
/// Observations with a smaller redundancy number are not controlled by the others, which would not show their
/// bias.
inline constexpr double kUncontrolled = 1e-6;
/// Factors of 95 % regions: sqrt of chi-square quantiles of 2 and 3 degrees of freedom.
inline constexpr double kEllipse95 = 2.4477;
inline constexpr double kEllipsoid95 = 2.7955;

/// Reliability of one used arrival, given the others (Baarda 1968, A testing procedure for use in geodetic
/// networks).
struct ArrivalReliability {
  std::size_t run = 0;      ///< index into Problem::runs
  std::size_t arrival = 0;  ///< index into MeasurementLog::arrivals
  BeaconId beacon;
  ReceiverId receiver;
  double residual_s = 0.0;   ///< observed minus adjusted; positive: late
  double redundancy = 0.0;   ///< r: share of its error that shows in its own residual, 0..1
  bool controlled = false;   ///< r above kUncontrolled; otherwise the following fields are zero
  double w = 0.0;            ///< residual / (sigma sqrt(r)), standard normal without biases
  double mdb_s = 0.0;        ///< minimal detectable bias sigma kDelta0 / sqrt(r)
  double mdb_m = 0.0;        ///< mdb_s as a range
  double influence_m = 0.0;  ///< largest shift of a beacon coordinate by an undetected bias of that size
};

/// Variance factor of a part of the observations: sum of squares divided by redundancy, one-step estimate
/// after Foerstner (1979): v'Pv / sum of r. For a part that is noisier than expected, if others are not, it
/// is somewhat too small.
struct VarianceComponent {
  std::string name;
  std::size_t observations = 0;
  double redundancy = 0.0;       ///< sum of r
  std::optional<double> factor;  ///< ratio to the given variance; no value if the redundancy is below 1
  std::optional<double> chi2_p;  ///< two-sided
};

/// Half axes of the region with the true position in 95 of 100 cases.
struct ErrorEllipse {
  double semi_major_m = 0.0, semi_minor_m = 0.0;  ///< horizontal, factor 2.45
  double azimuth_rad = 0.0;  ///< direction of the major axis, counter-clockwise from map +x, (-pi/2, pi/2]
  std::array<double, 3> semi_axes_m = {0, 0, 0};  ///< in space, largest first, factor 2.80
};

struct BeaconReliability {
  std::string name;
  /// Numbers of arrivals; late, early, other: rejected
  std::size_t used = 0, late = 0, early = 0, other = 0;
  std::size_t uncontrolled = 0;
  double mean_redundancy = 0.0;
  double rms_s = 0.0, mean_s = 0.0;  ///< statistics of the residuals of used arrivals
  VarianceComponent component;
  std::optional<double> mdb_median_s, mdb_worst_s;  ///< detectable biases of single controlled arrivals
  std::optional<double> influence_median_m, influence_worst_m;
  /// For an equal lateness of all its arrivals: smallest detectable value (if a free delay absorbs it, by the
  /// delay's prior), and the largest shift of a beacon coordinate by it. No value if it is not detectable.
  std::optional<double> lateness_mdb_s, lateness_influence_m;
  std::optional<ErrorEllipse> ellipse;  ///< no value for control points and undetermined beacons
};

/// Reliability of an adjustment as surveyors report it, in addition to the variance factor. Sigmas use the
/// estimated noise (Solution::tof_sigma_s); variance components are relative to the noise in the site file.
struct Reliability {
  bool ok = false;  ///< false without a covariance
  /// Sampling interval of epochs in a long log for statistics of single arrivals (redundancy numbers, w,
  /// minimal detectable biases, residual groups, variance components); 1: all epochs.
  std::size_t stride = 1;
  std::vector<ArrivalReliability> arrivals;
  std::vector<std::size_t> worst;   ///< indices into arrivals, largest |w| first, at most kWorst
  std::size_t beyond_critical = 0;  ///< |w| > kCriticalW
  double mean_redundancy = 0.0;     ///< of arrivals
  /// Sum of all redundancy numbers, including priors and control distances: observations minus the unknowns
  /// that they determine.
  double redundancy_sum = 0.0;
  std::vector<BeaconReliability> beacons;  ///< order of the site
  std::vector<VarianceComponent>
      kinds;  ///< tof, amplitude, bearing, odometry, pose, prior, control_distance; those present
  std::vector<ResidualGroup> by_beacon, by_receiver, by_distance, by_temperature;
  /// Angle at the receiver from its axis, or if the site has no axis, of the path from the vertical.
  std::vector<ResidualGroup> by_incidence;
  std::vector<ResidualGroup> by_time;  ///< since the start of the recording
};
inline constexpr std::size_t kWorst = 10;
/// Number of epochs that suffices for means, with a time similar to the adjustment's.
inline constexpr std::size_t kAllEpochs = 6000;

/// @param all_epochs    number of epochs up to which all are used; otherwise an even sample
/// @param whole         counts of the complete log, if the trajectories are only a part of it
/// @param trajectories  solved at the solution's state, arrivals marked used or rejected
/// @param state         adjusted shared parameters
/// @param C             joint covariance of the layout's parameters
/// @param noise_factor  ratio of the estimated noise of the arrivals to that of the site file
[[nodiscard]] Reliability reliability_of(const Problem& problem, const ParameterLayout& layout,
                                         const std::vector<Trajectory>& trajectories,
                                         const SharedState& state, const Covariance& C,
                                         const std::vector<BeaconStatus>& beacon_status, double noise_factor,
                                         int threads = 1, std::size_t all_epochs = kAllEpochs,
                                         const LogTotals* log = nullptr);
/// Sampling interval of epochs.
[[nodiscard]] inline std::size_t sample_stride(std::size_t epochs, std::size_t all_epochs = kAllEpochs) {
  return epochs > all_epochs ? (epochs + all_epochs - 1) / all_epochs : 1;
}

/// 95 % regions of a position.
[[nodiscard]] ErrorEllipse error_ellipse(const Eigen::Matrix3d& covariance_m2);

}  // namespace octant::calib
