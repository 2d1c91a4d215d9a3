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
  Drift drift;  ///< allowed for since the earlier calibration
};

/// A second visit to a calibrated site: as found, as left.
struct Revisit {
  SolveStatus status = SolveStatus::kNotConverged;
  std::string message;    ///< one sentence on the outcome
  std::string remedy;     ///< what to record or to do where there is none
  Comparison comparison;  ///< as found, owners and columns of the earlier deployment
  std::vector<Heard> beacons, receivers;
  std::vector<Silence> silent;            ///< beacons and receivers received far less than expected
  std::vector<std::string> not_observed;  ///< beacons out of reach along this path; carried over
  std::vector<std::string> not_judged;    ///< beacons received at a single stop, which shows no change
  MediumFound medium;
  Drift drift;         ///< as allowed for: where no thermometer was read the speed may be any
  Deployment as_left;  ///< status kConverged; provenance is not filled in (finished())
  std::vector<std::string> warnings;
  double seconds = 0.0;
};

/// What a second visit says changed, and the calibration as it is now.
///
/// The earlier deployment is a Gaussian prior of all that it knew, its joint covariance C widened by a drift
/// D. Of a beacon that moved nothing of that holds, and arrivals that contradict a narrow prior would be left
/// out as outliers; so
///   1. the visit is adjusted with room for changes of any usual size in everything, control points too (the
///   vehicle's poses float, so
///      that a control point that was knocked bends nothing else),
///   2. what the visit says on its own is taken out of that (visit_information.h), compared with C + D, and
///   the set of changes is
///      searched that explains the difference best (change_search.h): linear algebra, no further adjustment,
///   3. it is adjusted again with these released and all else held by C + D, until the same changes are
///   found.
/// As left: theta = theta_1 + (P^-1 + N)^-1 N (theta_2 - theta_1), P = C + D + what was released. What was
/// held (control points, a stated receiver) stays as it is where it is not found changed. Errors: runs that
/// do not fit the site.
[[nodiscard]] Result<Revisit> revisit(const Deployment& before, std::vector<MeasurementLog> runs,
                                      const RevisitOptions& options);

}  // namespace octant::calib
