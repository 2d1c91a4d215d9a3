// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/problem/log_health.h"
#include "calib/problem/problem.h"
#include "calib/problem/subsample.h"
#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"

namespace octant::calib {

/// Predicted result of a calibration with all data, for one beacon.
struct BeaconForecast {
  std::string name;
  BeaconStatus status = BeaconStatus::kUndetermined;
  std::size_t arrivals = 0;                   ///< in all runs, subsampled or not
  std::optional<Eigen::Vector3d> position_m;  ///< position in the quick adjustment; no value if not found
  std::optional<Eigen::Vector3d> sigma_m;  ///< predicted for all data; no value if not found or not received
  double delay_sigma_s = 0.0;              ///< predicted; 0: fixed
};

/// Outcome of a calibration, predicted from a part of its data.
struct Forecast {
  /// Solution of the subsampled runs. Covariance, beacon status, weak directions, undetermined parameters and
  /// status are those expected with all arrivals. Indices of trajectories and rejected arrivals refer to
  /// `subsampled`.
  Solution solution;
  Problem subsampled;
  std::vector<BeaconForecast> beacons;          ///< order of the site
  double speed_mps = 0.0;                       ///< speed in the first run; 0 without a solution
  std::optional<double> speed_sigma_mps;        ///< predicted; 0: fixed
  std::size_t arrivals = 0, arrivals_used = 0;  ///< number in all runs, and in the subsampled ones
  std::size_t states = 0, states_used = 0;      ///< vehicle states
  [[nodiscard]] bool is_subsampled() const { return arrivals_used < arrivals; }
};

/// Calibrates a subsampled problem (subsample.h), predicts its accuracy with all arrivals, and explains a
/// poor outcome (readings/explain.h). The weight of each beacon's arrivals is their number relative to the
/// subsample. The prediction includes the effect of noise, not of constant errors. Descriptions and
/// undetermined parameters are those of solve(). Takes seconds if solve() takes minutes.
[[nodiscard]] Forecast forecast(const Problem& whole, const SolveOptions& options = {},
                                const SubsampleOptions& subsample_options = {});

/// Findings of a quick solution; empty without a solution.
[[nodiscard]] std::vector<Finding> suspicions(const Forecast& forecast, std::vector<RunHealth>& runs);

}  // namespace octant::calib
