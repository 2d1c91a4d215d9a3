// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "calib/errors/statistics.h"
#include "calib/problem/log_totals.h"
#include "calib/verdict/conclude.h"

namespace octant::calib {

struct GatheredFindings : Findings {
  std::vector<std::vector<Arrival>> arrivals;  ///< arrivals of each run, for the states in memory
};

/// Findings of a pass over a part of a log about one of its trajectories.
struct TrajectoryFindings {
  const Trajectory& trajectory;  ///< solved, outliers rejected
  const MeasurementLog& log;     ///< with the part's arrivals
  Trajectory sampled;            ///< sampled states
  std::vector<std::int64_t> flipped = {};
  std::size_t counted_before = 0;  ///< unknowns of states that another part counts
};

/// Collects the findings of a log, for stops and drives, part by part. Each part writes its findings as
/// numbers. Those of all parts and ranks are concatenated and read back in the order of the parts.
class FindingsGatherer {
 public:
  /// @param frame   outlives it; with all bearings
  /// @param states  of the whole log
  FindingsGatherer(const Problem& frame, const Estimate& estimate, std::size_t states);

  [[nodiscard]] const SharedState& state() const { return state_; }
  /// Sampling interval of stops, or of segments of a drive.
  [[nodiscard]] std::size_t stride() const { return totals_.stride; }

  /// Appends a part's numbers; several threads may write side by side.
  void write(const TrajectoryFindings& part, std::vector<double>& numbers) const;
  /// Reads the numbers of all parts.
  void read(const std::vector<double>& numbers);
  /// Arrivals of a beacon that no state carries.
  void count_stateless(std::size_t beacon, std::size_t arrivals);
  [[nodiscard]] GatheredFindings findings(const Estimate& estimate) &&;

 private:
  /// Findings of a run and a vehicle.
  struct GatheredTrajectory {
    std::vector<std::int64_t> flipped;
    std::size_t stateless = 0;  ///< arrivals
    int stateless_line = 0;     ///< line of the first of them
    Trajectory some;
  };

  void leave_out_bearings_of_no_state();

  const Problem& frame_;
  TrajectoryModel model_;
  SharedState state_;
  LogTotals totals_;
  ObservationCounts counts_;
  std::map<std::pair<std::size_t, std::size_t>, GatheredTrajectory> of_trajectory_;
  std::vector<std::vector<bool>> carried_;  ///< for each run, the bearings that belong to a state
  GatheredFindings findings_;
};

}  // namespace octant::calib
