// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "calib/adjust/reject.h"
#include "calib/problem/ranges.h"
#include "calib/start/approach.h"
#include "calib/stream/pass_sum.h"
#include "calib/verdict/conclude.h"
#include "models/support/result.h"

namespace octant::calib {

/// What is to be said of all arrivals of a log, and some of its states.
struct LogFindings {
  Findings findings;
  std::vector<std::vector<Arrival>> arrivals;  ///< of each run, those of the states at hand
  std::vector<Trajectory> trajectories;        ///< of these
};

/// Evenly spread arrivals of a log, as many as agreeing_sigma() and typical_range_m() look at.
class SpreadArrivals {
 public:
  SpreadArrivals(std::size_t arrivals, SharedState at_estimate, SharedState prior)
      : every_residual_(arrivals / kResiduals + 1),
        every_range_(arrivals / kRanges + 1),
        state_(std::move(at_estimate)),
        prior_(std::move(prior)) {}

  /// @param number  of the arrival in the log
  void look_at(std::size_t number, const Trajectory& t, const ArrivalObservation& a,
               std::vector<double>& residuals, std::vector<double>& ranges_m) const {
    if (number % every_range_ == 0) ranges_m.push_back(prior_range_m(t, a, prior_));
    if (number % every_residual_ == 0 && a.rejection == Rejection::kUsed && t.nodes[a.node].placed)
      residuals.push_back(std::abs(arrival_residual(t, a, state_)));
  }

 private:
  static constexpr std::size_t kResiduals = 200000, kRanges = 50000;
  std::size_t every_residual_, every_range_;
  SharedState state_, prior_;
};

/// A log that is read again for each look at it. Errors of all: those of reading, Errc::kInterrupted where
/// the course is to stop.
class LogReadings {
 public:
  virtual ~LogReadings() = default;

  struct Placed {
    std::vector<double> residuals;  ///< magnitudes of evenly spread ones
    std::vector<double> ranges_m;   ///< the same, by the site's priors
    std::optional<PassSum> sum;     ///< where marks were asked for, and came along
  };
  /// Places all states anew.
  /// @param mark  may reject, settle with plain squares and sum up as well
  [[nodiscard]] virtual Result<Placed> place(const Estimate& estimate, double suspect_sigmas, bool mark) = 0;

  /// Settles all states at the estimate.
  [[nodiscard]] virtual Result<PassSum> pass(const Estimate& estimate, MarkPolicy marks) = 0;
  /// The last pass was a step forward: the next one may be told from there.
  virtual void accept() {}

  /// What is to be said of all arrivals at the end, and some of the states to look at.
  [[nodiscard]] virtual Result<LogFindings> findings(const Estimate& estimate) = 0;

 protected:
  LogReadings() = default;
  LogReadings(const LogReadings&) = default;
  LogReadings& operator=(const LogReadings&) = default;
};

}  // namespace octant::calib
