// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "calib/errors/common_error.h"
#include "calib/errors/error_model.h"
#include "calib/errors/reliability.h"
#include "calib/problem/log_totals.h"
#include "models/contradiction.h"
#include "models/deployment.h"
#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

enum class SolveStatus {
  kConverged,
  kNotConverged,  ///< the iteration did not converge (exit 4)
  kUndetermined,  ///< the data do not determine a necessary parameter (exit 5)
  kInterrupted    ///< the user asked to stop (exit 130)
};
[[nodiscard]] const char* to_string(SolveStatus status);

/// A combination of parameters that data and priors do not determine well.
struct WeakDirection {
  std::string description;              ///< in words: "speed of sound and overall scale"
  std::vector<std::string> parameters;  ///< largest parts first, names as in the joint covariance
  double sigma_m = 0.0;                 ///< sigma in metres at the beacons; infinite: unknown
  double consequence_m = 0.0;           ///< at the robot; 0 for a beacon that localizers leave out
  std::string remedy;                   ///< the cheapest measurement that determines it
  bool blocking = false;                ///< practically singular: no export
  bool lone_beacon = false;             ///< an undetermined beacon, which does not block the others
};

/// Covariance of sites with too many parameters for a joint covariance: one for the parameters of each
/// beacon, and one for those that belong to no single beacon. SI units, order of `parameters`; other pairs
/// have no element.
struct MarginalCovariance {
  std::vector<ParameterId> parameters;
  Eigen::SparseMatrix<double> matrix;
};

/// A rejected arrival.
struct LeftOut {
  std::size_t run = 0;      ///< index into Problem::runs
  std::size_t arrival = 0;  ///< index into MeasurementLog::arrivals
  Rejection reason = Rejection::kUsed;
  double residual_s = 0.0;
};

/// A rejected bearing.
struct LeftOutBearing {
  std::size_t run = 0;                  ///< index into Problem::runs
  std::size_t bearing = 0;              ///< index into MeasurementLog::bearings
  Rejection reason = Rejection::kUsed;  ///< kLate, kEarly: it deviates to one side or the other
};

/// A measured pose that was not used.
struct LeftOutPose {
  std::size_t run = 0;                       ///< index into Problem::runs
  std::size_t pose = 0;                      ///< index into MeasurementLog::poses
  Rejection reason = Rejection::kNotNeeded;  ///< no observation between it and its neighbours
};

/// The search for contradictions, which begins when the solution is complete.
struct Diagnosis {
  double fit_s = 0.0;         ///< time of the calibration without it
  double spent_s = 0.0;       ///< time of the search
  bool is_cut_short = false;  ///< it was interrupted, or its time was over, before the end
};

/// Result of a calibration. Numerical failures are data here, never an exception and never NaN.
struct Solution {
  SolveStatus status = SolveStatus::kNotConverged;
  std::string message;  ///< one sentence on the outcome
  int iterations = 0;
  double seconds = 0.0;
  double final_cost = 0.0;               ///< half the weighted sum of squares of arrivals, poses and priors
  SharedState state;                     ///< beacons, delays, speed, receivers, attenuation
  std::vector<Trajectory> trajectories;  ///< adjusted vehicle states, arrivals marked used or rejected
  std::vector<BeaconStatus> beacon_status;
  JointCovariance covariance;              ///< SI units; empty if it would be too large
  MarginalCovariance marginals;            ///< set in that case
  JointCovariance white_covariance;        ///< covariance under white errors; empty if `covariance` is that
  ErrorModel errors;                       ///< correlation of the errors of arrivals
  std::vector<CommonError> common_errors;  ///< errors shown by the residuals that no parameter absorbs
  Datum datum;
  CalibrationStatistics statistics;
  Reliability reliability;   ///< redundancy numbers, detectable biases, error ellipses, variance components
  double tof_sigma_s = 0.0;  ///< estimated noise of the arrivals
  std::vector<LeftOut> left_out;  ///< arrivals of the trajectories
  std::vector<LeftOutBearing> left_out_bearings;
  std::vector<LeftOutPose> left_out_poses;
  std::vector<bool> beacon_mirrored;  ///< its mirror image explains all observations equally well
  /// Counts over the whole of a streamed log, of which the trajectories are only a part.
  std::optional<LogTotals> totals;
  std::vector<WeakDirection> weak;
  std::vector<std::string> undetermined;  ///< names of parameters
  std::vector<Contradiction>
      contradictions;  ///< contradictions between assumptions and data; if there are any, there is no export
  Diagnosis diagnosis;
  std::vector<std::string> warnings;
};

}  // namespace octant::calib
