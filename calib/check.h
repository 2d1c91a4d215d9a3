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

/// What a calibration of all the data would make of one beacon.
struct BeaconForecast {
  std::string name;
  BeaconStatus status = BeaconStatus::kUndetermined;
  std::size_t arrivals = 0;                   ///< in all runs, subsampled or not
  std::optional<Eigen::Vector3d> position_m;  ///< where the quick adjustment has it; none: not found
  std::optional<Eigen::Vector3d> sigma_m;     ///< predicted for all the data; none: not found, or unseen
  double delay_sigma_s = 0.0;                 ///< predicted; 0: held fixed
};

/// Outcome of a calibration, predicted from a part of its data.
struct Forecast {
  /// The solution of the subsampled runs, but covariance, beacon status, weak directions, undetermined
  /// parameters and status are judged as if every arrival had taken part. Indices of trajectories and
  /// arrivals left out refer to `subsampled`.
  Solution solution;
  Problem subsampled;
  std::vector<BeaconForecast> beacons;          ///< order of the site
  double speed_mps = 0.0;                       ///< of the first run; 0 without a solution
  std::optional<double> speed_sigma_mps;        ///< predicted; 0: held fixed
  std::size_t arrivals = 0, arrivals_used = 0;  ///< of all, of the subsampled runs
  std::size_t states = 0, states_used = 0;      ///< vehicle states
  [[nodiscard]] bool is_subsampled() const { return arrivals_used < arrivals; }
};

/// Calibrates a subsampled problem (subsample.h) and judges it with the information that all arrivals would
/// bring, and says what contradicts it (readings/explain.h): each beacon's arrivals weigh by how many there
/// are of it for each one kept. Predicts the scatter that the data's noise causes, not the effect of errors
/// that stay. Same words, same undetermined parameters as solve(). Seconds where solve() takes minutes.
[[nodiscard]] Forecast forecast(const Problem& whole, const SolveOptions& options = {},
                                const SubsampleOptions& subsample_options = {});

/// What a quick solution shows; nothing where nothing was solved.
[[nodiscard]] std::vector<Finding> suspicions(const Forecast& forecast, std::vector<RunHealth>& runs);

}  // namespace octant::calib
