// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "calib/revisit/as_left.h"
#include "calib/revisit/heard.h"
#include "models/changes/comparison.h"
#include "models/deployment.h"
#include "models/run.h"
#include "models/support/result.h"

namespace octant::calib {

struct RevisitOptions {
  SolveOptions solve;
  Drift drift;  ///< drift since the earlier calibration
};

/// A second visit to a calibrated site: changes found, and the new calibration.
struct Revisit {
  SolveStatus status = SolveStatus::kNotConverged;
  std::string message;    ///< one sentence on the outcome
  std::string remedy;     ///< advice for further recordings, if there is no result
  Comparison comparison;  ///< changes found, with owners and columns of the earlier deployment
  std::vector<Heard> beacons, receivers;
  std::vector<Silence> silent;            ///< beacons and receivers received far less than expected
  std::vector<std::string> not_observed;  ///< beacons out of reach along this path; carried over
  std::vector<std::string> not_judged;    ///< beacons received at a single stop, which shows no change
  MediumFound medium;
  Drift drift;         ///< as assumed; the speed is free if no temperature was recorded
  Deployment as_left;  ///< status kConverged; provenance is not filled in (finished())
  std::vector<std::string> warnings;
  double seconds = 0.0;
};

/// Finds the changes since the earlier calibration, and the calibration of now.
///
/// The earlier deployment is a Gaussian prior, its joint covariance C enlarged by a drift D. For a beacon
/// that moved this prior is wrong, and arrivals that contradict a narrow prior would be rejected as outliers.
/// Therefore
///   1. the visit is adjusted with a prior wide enough for common changes of all parameters, also of control
///      points (the vehicle's poses are free, so a control point that moved distorts nothing else),
///   2. the information of the visit alone is extracted (visit_information.h) and compared with C + D, and
///      the set of changes that explains the difference best is searched by linear algebra (change_search.h),
///   3. it is adjusted again with these released and all else under C + D, until the same changes are found.
/// New calibration: theta = theta_1 + (P^-1 + N)^-1 N (theta_2 - theta_1), P = C + D + released variances.
/// Fixed values (control points, fixed receivers) remain unless they changed. Errors: runs that do not fit
/// the site.
[[nodiscard]] Result<Revisit> revisit(const Deployment& before, std::vector<MeasurementLog> runs,
                                      const RevisitOptions& options);

}  // namespace octant::calib
