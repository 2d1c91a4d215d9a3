// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/run.h"
#include "models/site.h"

namespace octant::survey {

/// A limit for a figure.
struct Gate {
  std::string name;  ///< "fix_m": position RMSE; "matched": how many fixes the reference covers (at least)
  double limit = 0.0;
  double value = 0.0;
  bool pass = false;
};

/// Enough for a curve.
inline constexpr std::size_t kErrorQuantiles = 101;

/// Error figures of ISO/IEC 18305 of some fixes. Position errors are horizontal for planar motion, in space
/// otherwise.
struct ErrorFigures {
  double mean_m = 0.0;
  double rmse_m = 0.0;
  double ce50_m = 0.0, ce95_m = 0.0;         ///< circular errors: quantiles of the horizontal error
  std::optional<double> ve95_m{}, se95_m{};  ///< vertical and spherical error, for motion in space
};

/// Latency of fixes (latency.h).
struct LatencyFigures {
  double mean_s = 0.0, p95_s = 0.0, largest_s = 0.0;
};

/// Fixes of one recording, or of one floor.
struct RunFigures {
  std::string name;
  std::size_t fixes = 0, no_fix = 0, matched = 0;
  ErrorFigures errors{};
  /// Share of the epochs or instants that have a fix, and of the reference's poses that have one within its
  /// max_gap_s.
  double availability = 0.0, coverage = 0.0;
};

/// Fixes against a reference trajectory.
struct Evaluation {
  std::size_t fixes = 0;  ///< with status ok
  std::size_t no_fix = 0;
  std::size_t matched = 0;       ///< fixes for which truth.tum has a pose
  double position_rmse_m = 0.0;  ///< horizontal for planar motion, in space otherwise
  double position_p95_m = 0.0;
  double max_error_m = 0.0;
  std::vector<double>
      error_quantiles_m;  ///< quantiles of the position errors, ascending, at most kErrorQuantiles
  std::optional<double> heading_rmse_rad;  ///< where the reference has a heading
  std::optional<double> nees_mean;         ///< over its degrees of freedom: 1 for honest covariances
  ErrorFigures errors{};
  double availability = 0.0, coverage = 0.0;  ///< as in RunFigures
  std::optional<LatencyFigures> latency;      ///< where the time of reception was logged
  std::vector<RunFigures> runs;
  /// From the lowest one upwards, if the heights of the reference form several groups: "0.4 m" is the mean
  /// height of a group. Epochs without a fix count where the reference is at that time.
  std::vector<RunFigures> floors;
  std::vector<Gate> gates;
  [[nodiscard]] bool pass() const;
};

/// Fixes of one recording with its reference trajectory.
struct ReferencedRun {
  std::vector<Fix> fixes;
  std::vector<TimedPose> truth;  ///< ordered by time
  PoseAccuracy truth_accuracy;
  std::string name{};
  /// Point of the vehicle that fixes of an open attitude locate (models/localizers/common/open_attitude.h).
  /// They are compared there if the reference has an attitude.
  Eigen::Vector3d p_located_vehicle_m = Eigen::Vector3d::Zero();
  std::vector<double> latencies_s{};  ///< of the fixes whose latency is known
};

/// Compares each fix with the reference interpolated at its time (never beyond its ends, nor over gaps longer
/// than truth_accuracy.max_gap_s), and the summary with the site's tolerance. The covariance in the NEES is
/// the sum of those of the fix and of the reference. If no fix has a reference, the figures are zero and the
/// gate "matched" fails, so that missing data never pass.
[[nodiscard]] Evaluation evaluate(const std::vector<Fix>& fixes, const std::vector<TimedPose>& truth,
                                  const PoseAccuracy& truth_accuracy, Motion motion,
                                  const Tolerance& tolerance);
/// Compares the fixes of several recordings together.
[[nodiscard]] Evaluation evaluate(const std::vector<ReferencedRun>& runs, Motion motion,
                                  const Tolerance& tolerance);

/// Distance of a calibrated beacon from the beacon of the same name in a reference deployment, in the same
/// frame.
struct BeaconError {
  std::string name;
  double error_m = 0.0;
};
/// Estimated beacons; control points, undetermined ones and those that are missing in the reference are left
/// out.
[[nodiscard]] std::vector<BeaconError> beacon_errors(const Deployment& deployment,
                                                     const Deployment& reference);

}  // namespace octant::survey
