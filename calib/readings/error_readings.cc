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

/// With an error of that kind and of any size, of either sign.
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

/// Smaller or larger than it was found, as what is blamed and what is left out have taken up some of it.
ReadingFamily about_as_found(const CommonError& error, const Site& site,
                             const std::vector<MeasurementLog>& runs) {
  constexpr double kLeast = 0.5, kMost = 16.0;
  return with_error(error, kLeast * std::abs(error.size), kMost * std::abs(error.size), site, runs);
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

std::vector<ReadingFamily> with_common_errors(const std::vector<CommonError>& errors, const Site& site,
                                              const std::vector<MeasurementLog>& runs) {
  constexpr std::size_t kClearest = 3;
  std::vector<ReadingFamily> families;
  for (const CommonError& error : errors)
    if (!is_of_odometry(error) && error.kind != CommonError::Kind::kShift && families.size() < kClearest)
      families.push_back(about_as_found(error, site, runs));
  return families;
}

std::vector<ReadingFamily> poses_that_shift(const std::vector<CommonError>& errors, const Site& site,
                                            const std::vector<MeasurementLog>& runs) {
  const auto shift = std::ranges::find(errors, CommonError::Kind::kShift, &CommonError::kind);
  if (shift == errors.end()) return {};
  return {about_as_found(*shift, site, runs)};
}

}  // namespace octant::calib
