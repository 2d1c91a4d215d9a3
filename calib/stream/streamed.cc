// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/streamed.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "calib/calibrator.h"
#include "calib/problem/thin.h"
#include "calib/stream/streamed_log.h"

namespace octant::calib {
namespace {

/// Rows, observations, tiles and marks of one arrival; rows, states and their systems of one odometry row.
constexpr std::size_t kBytesOfWhole = 220, kBytesOfWholeStep = 850;
}  // namespace

std::size_t memory_of_whole(std::size_t arrivals, std::size_t odometry_rows) {
  return arrivals * kBytesOfWhole + odometry_rows * kBytesOfWholeStep;
}

std::size_t least_memory_streamed(std::size_t arrivals, std::size_t odometry_rows) {
  constexpr std::size_t kMega = std::size_t{1} << 20, kProgram = 20 * kMega;
  constexpr std::size_t kLookedAt = 110'000, kBytesLookedAt = 1600;
  constexpr std::size_t kOfDrives = 90 * kMega, kBytesOfStep = 115;  // rows, states, stretches looked at
  if (odometry_rows > 0) return kOfDrives + odometry_rows * kBytesOfStep;
  return kProgram + std::min(arrivals, kLookedAt) * kBytesLookedAt + 7 * arrivals / 2;
}

std::optional<std::string> why_not_streamed(const Site& site, const std::vector<const MeasurementLog*>& runs,
                                            int dense_limit) {
  Problem frame;
  frame.site = site;
  for (const MeasurementLog* run : runs) frame.runs.push_back(without_lists(*run));
  if (const int size =
          make_layout(frame, prior_state(site), std::vector<bool>(site.beacons.size(), false)).size();
      size > dense_limit)
    return fmt::format("there are {} parameters, more than {}", size, dense_limit);
  return {};
}

Result<StreamedCalibration> solve_streamed(const Site& site, ArrivalSource& source,
                                           const SolveOptions& options, std::size_t memory_bytes) {
  Course course(options);
  StreamedLog log(site, source, options, course, memory_bytes);
  auto solution = calibrate(log, options, course);
  if (!solution) return fail(solution.error());
  StreamedCalibration done{std::move(log).taken_problem(), std::move(*solution)};
  done.problem.trajectories.clear();
  return done;
}

}  // namespace octant::calib
