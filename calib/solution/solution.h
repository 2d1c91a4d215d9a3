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
  kNotConverged,  ///< the iteration did not settle (exit 4)
  kUndetermined,  ///< the data cannot tell something that the rest hangs on (exit 5)
  kInterrupted    ///< the user asked to stop (exit 130)
};
[[nodiscard]] const char* to_string(SolveStatus status);

/// A combination of parameters about which data and priors say too little.
struct WeakDirection {
  std::string description;              ///< in words: "speed of sound and overall scale"
  std::vector<std::string> parameters;  ///< largest parts first, names as in the joint covariance
  double sigma_m = 0.0;        ///< of the combination, in metres at the beacons; infinite: nothing is known
  double consequence_m = 0.0;  ///< at the robot; 0 for a beacon that localizers leave out
  std::string remedy;          ///< the cheapest measurement that settles it
  bool blocking = false;       ///< singular for the purpose: nothing may be exported
  bool lone_beacon = false;    ///< an undetermined beacon, which does not block the others
};

/// Covariance of sites with so many parameters that the joint one is not formed: it has each beacon's
/// parameters among themselves, and those that no one beacon has. SI units, order of `parameters`; other
/// pairs have no element.
struct MarginalCovariance {
  std::vector<ParameterId> parameters;
  Eigen::SparseMatrix<double> matrix;
};

/// An arrival that was left out.
struct LeftOut {
  std::size_t run = 0;      ///< index into Problem::runs
  std::size_t arrival = 0;  ///< index into MeasurementLog::arrivals
  Rejection reason = Rejection::kUsed;
  double residual_s = 0.0;
};

/// A bearing that was left out.
struct LeftOutBearing {
  std::size_t run = 0;                  ///< index into Problem::runs
  std::size_t bearing = 0;              ///< index into MeasurementLog::bearings
  Rejection reason = Rejection::kUsed;  ///< kLate, kEarly: it does not fit, to the one side or the other
};

/// A measured pose that was left out.
struct LeftOutPose {
  std::size_t run = 0;                       ///< index into Problem::runs
  std::size_t pose = 0;                      ///< index into MeasurementLog::poses
  Rejection reason = Rejection::kNotNeeded;  ///< nothing was observed between it and its neighbours
};

/// The search for what contradicts the data, which begins when the solution is complete.
struct Diagnosis {
  double fit_s = 0.0;         ///< time of the calibration without it
  double spent_s = 0.0;       ///< time of the search
  bool is_cut_short = false;  ///< its time was over, or it was interrupted, before all was examined
};

/// Result of a calibration. Numerical trouble is data here, never an exception and never NaN.
struct Solution {
  SolveStatus status = SolveStatus::kNotConverged;
  std::string message;  ///< one sentence on the outcome
  int iterations = 0;
  double seconds = 0.0;
  double final_cost = 0.0;               ///< half the weighted sum of squares of arrivals, poses and priors
  SharedState state;                     ///< beacons, delays, speed, receivers, attenuation
  std::vector<Trajectory> trajectories;  ///< adjusted vehicle states, arrivals marked used or rejected
  std::vector<BeaconStatus> beacon_status;
  JointCovariance covariance;              ///< SI units; empty where it would be too large
  MarginalCovariance marginals;            ///< then these
  JointCovariance white_covariance;        ///< as if errors were white; empty where `covariance` is that
  ErrorModel errors;                       ///< how the errors of arrivals hang together
  std::vector<CommonError> common_errors;  ///< that no parameter takes up, as the residuals show them
  Datum datum;
  CalibrationStatistics statistics;
  Reliability reliability;   ///< redundancy numbers, detectable biases, error ellipses, variance components
  double tof_sigma_s = 0.0;  ///< noise of the arrivals as found
  std::vector<LeftOut> left_out;  ///< arrivals of the trajectories
  std::vector<LeftOutBearing> left_out_bearings;
  std::vector<LeftOutPose> left_out_poses;
  std::vector<bool> beacon_mirrored;  ///< its mirror image is as good by all observations
  /// Counts over all of a log that was streamed, as the trajectories are only a part of it.
  std::optional<LogTotals> totals;
  std::vector<WeakDirection> weak;
  std::vector<std::string> undetermined;  ///< names of parameters
  std::vector<Contradiction>
      contradictions;  ///< of what was stated and what the data say; not empty: not to be exported as it is
  Diagnosis diagnosis;
  std::vector<std::string> warnings;
};

}  // namespace octant::calib
