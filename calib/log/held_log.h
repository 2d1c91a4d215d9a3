// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/log/calibration_log.h"
#include "calib/start/progress_monitor.h"

namespace octant::calib {

/// A log in memory. Its inliers are adjusted by Ceres on tiles, to rest in each round of rejection: where a
/// beacon is hardly known that creeps along a bent valley, and sites of very many parameters have sparse
/// matrices.
class HeldLog : public CalibrationLog {
 public:
  /// All arguments must outlive it.
  /// @param own_trajectories  those of the problem, if they may be moved; otherwise null
  HeldLog(const Problem& problem, const SolveOptions& options, ProgressMonitor& monitor,
          std::vector<Trajectory>* own_trajectories = nullptr)
      : problem_(problem), options_(options), monitor_(monitor), own_trajectories_(own_trajectories) {}

  [[nodiscard]] const Problem& problem() const override { return problem_; }
  [[nodiscard]] Result<Sample> next_sample() override;
  [[nodiscard]] Result<double> place(Approach& start, double sigma) override;
  [[nodiscard]] Result<DataSquares> adjust_inliers(Estimate& estimate) override;
  void scale_noise(Estimate& estimate, const NoiseFactors& factors) override;
  [[nodiscard]] Result<Findings> findings(const Estimate& estimate) override;
  void resume(const std::vector<Trajectory>& trajectories) override;

 private:
  bool adjust_to_rest(Estimate& estimate);
  [[nodiscard]] CalibrationStatistics statistics(const Estimate& estimate) const;

  const Problem& problem_;
  const SolveOptions& options_;
  ProgressMonitor& monitor_;
  std::vector<Trajectory>* own_trajectories_;
  std::optional<Problem> part_;
  bool is_complete_ = false;  ///< the last sample
  std::vector<Trajectory> trajectories_;
  std::vector<std::vector<double>> start_headings_rad_;
  std::optional<CalibrationStatistics> statistics_;  ///< at the last states, rejections and noise
};

}  // namespace octant::calib
