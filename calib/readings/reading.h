// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>

#include "models/contradiction.h"
#include "models/run.h"
#include "models/site.h"

namespace octant::calib {

/// A hypothesis on the inputs: the site file or a log may mean something else than it says.
struct Reading {
  Contradiction what;                     ///< contradiction to report if it is true; without `sigmas`
  std::function<Site(const Site&)> site;  ///< changed site; empty: unchanged
  std::function<void(std::size_t run, MeasurementLog&)> log;  ///< changes a run; empty: unchanged
  /// `log` must be applied to the whole recording, before subsampling.
  bool is_of_whole = false;
};

/// Hypotheses that differ by one number, such as a time lag or a scale error.
struct ReadingFamily {
  std::function<Reading(double size)> reading;
  double least = 0.0, most = 0.0;           ///< range of sizes, of either sign
  std::function<bool(double)> may_be = {};  ///< false for sizes that explain nothing; empty: all may
};

/// Hypotheses on the time lag of a file against the arrivals, up to about two seconds.
/// @param subject, are_stamped  "in poses.tum", "they are stamped"
/// @param take_back  makes a run's times earlier by a lag
[[nodiscard]] ReadingFamily of_other_clock(ContradictionKind kind, const std::string& subject,
                                           const std::string& file, const std::string& are_stamped,
                                           void (*take_back)(double lag_s, MeasurementLog& run));

/// Size that explains the recordings best: steps by factors of two, the best of them refined to one percent.
/// @param loss  loss of the recordings after correction for a size; called about thirty times
/// @param loss_of_none  loss without a correction. One of the steps reduces any error to a third or less. If
/// no step reduces the loss there is no such error, and the result has no value.
[[nodiscard]] std::optional<double> likeliest_size(double least, double most, double loss_of_none,
                                                   const std::function<double(double)>& loss);

/// All hypotheses of several lists, in their order.
[[nodiscard]] inline std::vector<Reading> joined(std::initializer_list<std::vector<Reading>> lists) {
  std::vector<Reading> all;
  for (const std::vector<Reading>& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

}  // namespace octant::calib
