// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace octant::survey {

/// Estimate of a quantity by one calibration; SI units.
struct TrendValue {
  double time_s = 0.0;
  double value = 0.0;
  double sigma = 0.0;
};

/// A point of a control chart: a value against what the values before it foretell.
struct ChartPoint {
  TrendValue measured;
  std::optional<double>
      foretold;  ///< weighted mean of the earlier values; no value for the first point of a chart
  double deviation_sigmas = 0.0;    ///< measured less foretold, by the sigma of that difference
  double upper = 0.0, lower = 0.0;  ///< cumulative sums
  int alarm = 0;                    ///< +1: larger than before, -1: smaller
};

/// A change of level that the cumulative sums detect.
struct Shift {
  std::size_t at = 0;              ///< the point that gave the alarm
  std::size_t since = 0;           ///< the first point of the new level: the likeliest place of the change
  double size = 0.0, sigma = 0.0;  ///< new level less old
  bool by_drift = false;           ///< a straight line explains the values better than two levels
};

/// Straight line through the values since the last shift that was a step.
struct Drift {
  double per_s = 0.0, sigma_per_s = 0.0;  ///< sigma widened where the values scatter by more than they state
  double last_time_s = 0.0;
};

struct ControlChart {
  std::vector<ChartPoint> points;
  std::vector<Shift> shifts;
  std::optional<Drift> drift;  ///< by two values since the last step or more, a week apart or more
};

/// A control chart of recursive residuals: each value is compared with the weighted mean of those before it.
/// Without a change, the residuals are independent and N(0, 1) for any sigmas (Brown, Durbin, Evans, JRSS B
/// 37, 1975), as a self-starting CUSUM requires (Hawkins, JQT 19, 1987): the first value is not assumed to be
/// the truth. After an alarm, a new chart begins at the first point of the new level.
/// @param values           by time; sigmas of independent errors
/// @param k, h             of the cumulative sums (models/watch/cusum.h)
/// @param smallest_sigma   unit of a change if both values are fixed (surveyed positions)
[[nodiscard]] ControlChart control_chart(const std::vector<TrendValue>& values, double k, double h,
                                         double smallest_sigma);

/// When a drift will have moved a quantity by as much as may be.
struct Forecast {
  std::optional<double>
      due_s{};  ///< when the drift reaches the limit; no value if the drift is not significant (three sigmas)
  double earliest_s =
      0.0;  ///< if it is larger by two sigmas: before it no recalibration is needed for this quantity's sake
  std::optional<double>
      latest_s{};  ///< due time for a drift that is smaller by two sigmas; no value without due_s
};
/// @param limit  largest change that may be, of the quantity's unit; positive
[[nodiscard]] Forecast forecast(const Drift& drift, double limit);

}  // namespace octant::survey
