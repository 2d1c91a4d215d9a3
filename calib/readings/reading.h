// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "models/contradiction.h"
#include "models/run.h"
#include "models/site.h"

namespace octant::calib {

/// The statements as they might be meant: another site, or other recordings.
struct Reading {
  Contradiction what;                                         ///< if it is what is meant; without `sigmas`
  std::function<Site(const Site&)> site;                      ///< empty: as stated
  std::function<void(std::size_t run, MeasurementLog&)> log;  ///< of each run; empty: as recorded
  /// `log` is of the whole recording, before a part is taken and rows are summed up.
  bool is_of_whole = false;
};

/// Readings that differ by one number: by how much a clock is late, or a way too long.
struct ReadingFamily {
  std::function<Reading(double size)> reading;
  double least = 0.0, most = 0.0;           ///< sizes that are looked at, of either sign
  std::function<bool(double)> may_be = {};  ///< whether a size explains anything; empty: all do
};

/// Rows of a file whose clock is late or early against the arrivals', by up to some two seconds.
/// @param subject, are_stamped  "in poses.tum", "they are stamped"
/// @param take_back  makes a run's times earlier by a lag
[[nodiscard]] ReadingFamily of_other_clock(ContradictionKind kind, const std::string& subject,
                                           const std::string& file, const std::string& are_stamped,
                                           void (*take_back)(double lag_s, MeasurementLog& run));

/// The size that explains the recordings best: steps by factors of two, the best of them refined to a part in
/// a hundred.
/// @param loss  of the recordings when a size is taken back; some thirty are asked for
/// @param loss_of_none  of the recordings as they are: of the steps one at least leaves a third of an error
/// or less, so where none of them explains more there is no such error, and nothing is refined or returned
[[nodiscard]] std::optional<double> likeliest_size(double least, double most, double loss_of_none,
                                                   const std::function<double(double)>& loss);

}  // namespace octant::calib
