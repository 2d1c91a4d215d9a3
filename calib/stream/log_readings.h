// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "calib/adjust/reject.h"
#include "calib/problem/ranges.h"
#include "calib/problem/subsample.h"
#include "calib/start/approach.h"
#include "calib/stream/log_findings.h"
#include "calib/stream/pass_sum.h"
#include "calib/sums/over_ranks.h"
#include "models/arrival_source.h"
#include "models/support/result.h"

namespace octant::calib {

/// A log that is read in each pass. Errors of all functions: those of the reader, Errc::kInterrupted if the
/// calibration is cancelled.
class LogReadings {
 public:
  virtual ~LogReadings() = default;

  struct Placed {
    std::vector<double> residuals;  ///< magnitudes of evenly spread ones
    std::vector<double> ranges_m;   ///< ranges according to the priors of the site
    std::size_t states = 0;
    std::optional<PassSum> sum;  ///< where marks were asked for, and came along
  };
  /// Places all states again.
  /// @param mark  may reject, solve with plain squares and sum up as well
  [[nodiscard]] virtual Result<Placed> place(const Estimate& estimate, double suspect_sigmas,
                                             bool reject) = 0;

  /// Solves for all states at the estimate.
  [[nodiscard]] virtual Result<PassSum> pass(const Estimate& estimate, RejectionPolicy policy) = 0;
  /// The last pass improved the cost: the next one may be predicted from it.
  virtual void accept() {}

  /// Passes the final findings about the arrivals to the gatherer.
  [[nodiscard]] virtual Result<void> gather(const Estimate& estimate, FindingsGatherer& gatherer) = 0;

 protected:
  LogReadings() = default;
  LogReadings(const LogReadings&) = default;
  LogReadings& operator=(const LogReadings&) = default;
};

/// Passes over several kinds of states, whose sums are added.
class JoinedReadings : public LogReadings {
 public:
  void add(std::unique_ptr<LogReadings> readings) { all_.push_back(std::move(readings)); }
  [[nodiscard]] Result<Placed> place(const Estimate& estimate, double suspect_sigmas, bool reject) override;
  [[nodiscard]] Result<PassSum> pass(const Estimate& estimate, RejectionPolicy policy) override;
  void accept() override;
  [[nodiscard]] Result<void> gather(const Estimate& estimate, FindingsGatherer& gatherer) override;

 private:
  std::vector<std::unique_ptr<LogReadings>> all_;
};

/// Makes a worker's log one of another run. The room of its arrivals stays.
inline void begin_run(const MeasurementLog& run, MeasurementLog& log) {
  std::vector<Arrival> room = std::move(log.arrivals);
  log = without_lists(run);
  log.arrivals = std::move(room);
}

[[nodiscard]] inline Error changed_while_read(const MeasurementLog& log) {
  return {.file = log.path + "/tof.csv",
          .found = "the file has changed while it was read",
          .expected = "the same rows each time, as a log of this size is read several times",
          .advice = "calibrate with a copy, or when the recording is over"};
}

/// Input of the passes; it must outlive them.
struct ReadingTask {
  const Problem& frame;  ///< site and runs without arrivals
  const ArrivalSource& source;
  const SolveOptions& options;
  ProgressMonitor& monitor;
  int workers = 1;
  std::size_t arrivals = 0;  ///< arrivals of the whole log that belong to a state
};

/// Evenly spaced arrivals of the parts of a log, in the number that agreeing_sigma() and typical_range_m()
/// use.
class SpreadArrivals {
 public:
  SpreadArrivals(const ReadingTask& task, SharedState at_estimate, std::size_t parts)
      : every_residual_(task.arrivals / kResiduals + 1),
        every_range_(task.arrivals / kRanges + 1),
        state_(std::move(at_estimate)),
        prior_(prior_state(task.frame.site)),
        residuals_(parts),
        ranges_m_(parts) {}

  /// Collects a range before its state has a place. @param number  of the arrival in the log
  void add_range(std::size_t part, std::size_t number, const Trajectory& t, const ArrivalObservation& a) {
    if (number % every_range_ == 0) ranges_m_[part].push_back(prior_range_m(t, a, prior_));
  }
  void add_residual(std::size_t part, std::size_t number, const Trajectory& t, const ArrivalObservation& a) {
    if (number % every_residual_ == 0 && a.rejection == Rejection::kUsed && t.nodes[a.node].placed)
      residuals_[part].push_back(std::abs(arrival_residual(t, a, state_)));
  }
  /// Arrivals of all ranks, in the order of the parts.
  [[nodiscard]] LogReadings::Placed placed(const Ranks* ranks) && {
    return {in_order(ranks, std::move(residuals_)), in_order(ranks, std::move(ranges_m_)), 0, {}};
  }

 private:
  static constexpr std::size_t kResiduals = 200000, kRanges = 50000;
  std::size_t every_residual_, every_range_;
  SharedState state_, prior_;
  std::vector<std::vector<double>> residuals_, ranges_m_;
};

/// The noise of trajectories that were just read is the initial one.
inline void take_noise(const Problem& frame, const Estimate& estimate,
                       std::vector<Trajectory>& trajectories) {
  const double stated_s = frame.site.noise.tof_sigma_s;
  rescale_noise(trajectories, stated_s, stated_s * estimate.noise_factor);
  rescale_poses(trajectories, estimate.pose_factor);
}

}  // namespace octant::calib
