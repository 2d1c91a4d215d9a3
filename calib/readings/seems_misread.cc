// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/seems_misread.h"

#include <cmath>
#include <cstddef>

#include "calib/verdict/left_out.h"

namespace octant::calib {
namespace {

/// How an outcome looks that is worth a search.
constexpr double kEarlyShare = 0.05, kNoiseRatio = 3.0, kDraggedSigmas = 6.0;
constexpr std::size_t kEarlyAtLeast = 10;

bool is_dragged(const Problem& problem, const Solution& solution) {
  const Site& site = problem.site;
  for (std::size_t r = 0; r < site.receivers.size() && r < solution.state.receiver_p_vehicle_m.size(); ++r)
    for (int i = 0; i < 3; ++i) {
      const double sigma = site.receivers[r].sigma_m[i];
      if (sigma > 0 && std::abs(solution.state.receiver_p_vehicle_m[r][i] - site.receivers[r].position_m[i]) >
                           kDraggedSigmas * sigma)
        return true;
    }
  return false;
}

}  // namespace

bool seems_misread(const Problem& problem, const Solution& solution) {
  std::size_t rows = 0, early = 0;
  for (const MeasurementLog& run : problem.runs) rows += run.arrivals.size();
  if (rows == 0 || solution.status == SolveStatus::kInterrupted) return false;
  if (solution.status == SolveStatus::kNotConverged || solution.beacon_status.empty())
    return true;  // nothing came of it
  for (const LeftOut& l : solution.left_out) early += l.reason == Rejection::kEarly;
  const double all = static_cast<double>(rows);
  if (early >= kEarlyAtLeast && static_cast<double>(early) > kEarlyShare * all) return true;
  if (are_many_left_out(problem, solution)) return true;
  if (problem.site.noise.tof_sigma_s > 0 &&
      solution.tof_sigma_s > kNoiseRatio * problem.site.noise.tof_sigma_s)
    return true;
  return is_dragged(problem, solution);
}

}  // namespace octant::calib
