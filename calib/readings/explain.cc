// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/explain.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "calib/readings/readings.h"
#include "calib/verdict/left_out.h"

namespace octant::calib {
namespace {

/// How an outcome looks that is worth a search.
constexpr double kEarlyShare = 0.05, kNoiseRatio = 3.0, kDraggedSigmas = 6.0;
constexpr std::size_t kEarlyAtLeast = 10;

/// Arrivals of an outcome.
struct OutcomeCounts {
  std::size_t all = 0, out = 0, early = 0;  ///< out: those that do not fit, late or early
  OutcomeCounts(const Problem& problem, const Solution& solution) {
    for (const MeasurementLog& run : problem.runs) all += run.arrivals.size();
    for (const LeftOut& l : solution.left_out) {
      out += is_outlier(l.reason);
      early += l.reason == Rejection::kEarly;
    }
  }
};

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

/// Where much is left out, and not as echoes are late, something that was stated is wrong, whatever it is.
std::optional<Contradiction> early_beyond_chance(const Problem& problem, const Solution& solution) {
  constexpr double kMuchLeftOut = 0.3, kMuchEarly = 0.1;
  if (solution.status != SolveStatus::kConverged) return {};
  const OutcomeCounts n(problem, solution);
  const auto rows = static_cast<double>(n.all);
  if (static_cast<double>(n.out) < kMuchLeftOut * rows || static_cast<double>(n.early) < kMuchEarly * rows)
    return {};
  return Contradiction{
      ContradictionKind::kLog,
      "as a whole",
      "heard along straight paths",
      fmt::format("{} of {} arrivals not to fit, {} of them early, as no echo can be", n.out, n.all, n.early),
      0.0,
      "look at the places of control points and receivers, at which is wired as which, and at labels, units "
      "and frames; then calibrate again"};
}

}  // namespace

bool seems_misread(const Problem& problem, const Solution& solution) {
  const OutcomeCounts n(problem, solution);
  if (n.all == 0 || solution.status == SolveStatus::kInterrupted) return false;
  if (solution.status == SolveStatus::kNotConverged || solution.beacon_status.empty())
    return true;  // nothing came of it
  if (n.early >= kEarlyAtLeast && static_cast<double>(n.early) > kEarlyShare * static_cast<double>(n.all))
    return true;
  if (are_many_left_out(problem, solution)) return true;
  if (problem.site.noise.tof_sigma_s > 0 &&
      solution.tof_sigma_s > kNoiseRatio * problem.site.noise.tof_sigma_s)
    return true;
  return is_dragged(problem, solution);
}

void explain(const Problem& problem, const Problem& adjusted, Solution& solution,
             const SolveOptions& options) {
  const bool misread = seems_misread(adjusted, solution);
  if (!misread && solution.contradictions.empty()) return;
  std::vector<Contradiction> found = misread ? find_misreadings(problem, solution, options)
                                             : find_other_culprits(problem, solution, options);
  if (found.empty()) {
    if (auto early = early_beyond_chance(adjusted, solution); early && solution.contradictions.empty())
      solution.contradictions.push_back(std::move(*early));
    return;
  }
  solution.contradictions = std::move(found);
  if (solution.status != SolveStatus::kUndetermined) return;
  solution.message = "the recordings do not fit what was stated, and nothing is exported";
  solution.weak.clear();
}

}  // namespace octant::calib
