// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/error_readings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "calib/readings/odometry_readings.h"

namespace octant::calib {
namespace {

/// Hypotheses with a common error of some kind, of either sign and any size from `least` to `most`.
ReadingFamily with_error(CommonError error, double least, double most, const Site& site,
                         const std::vector<MeasurementLog>& runs) {
  std::vector<std::pair<double, double>> spans_s;
  spans_s.reserve(runs.size());
  for (const MeasurementLog& run : runs) spans_s.push_back(span_of(run.arrivals));
  error.sigmas = 0.0;
  const auto reading = [error, &site, &runs, spans_s](double size) -> Reading {
    CommonError sized = error;
    sized.size = size;
    return {contradiction_of(sized, site, runs),
            {},
            [sized, spans_s](std::size_t run, MeasurementLog& log) {
              if (is_of_odometry(sized) || run == sized.run) take_back(sized, spans_s[run], log);
            },
            true};
  };
  return {reading, least, most};
}

}  // namespace

std::vector<ReadingFamily> odometry_of_other_scale(const Site& site,
                                                   const std::vector<MeasurementLog>& runs) {
  constexpr double kLeast = 0.01, kMost = 0.5;
  const auto run = run_of_planar_odometry(runs);
  if (!run) return {};
  std::vector<ReadingFamily> families;
  for (const CommonError::Kind kind : {CommonError::Kind::kWay, CommonError::Kind::kTurns})
    families.push_back(with_error({.kind = kind, .run = *run}, kLeast, kMost, site, runs));
  return families;
}

}  // namespace octant::calib
