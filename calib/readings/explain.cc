// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/explain.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "calib/readings/pose_readings.h"
#include "calib/readings/readings.h"
#include "calib/solution/diagnosis_budget.h"
#include "calib/verdict/left_out.h"

namespace octant::calib {
namespace {

/// Limits from which an outcome is worth a search.
constexpr double kEarlyShare = 0.05, kNoiseRatio = 3.0, kDraggedSigmas = 6.0;
/// Ratio of the estimated noise to the expected one if residuals are correlated; weather alone causes less.
constexpr double kCorrelatedNoiseRatio = 1.5;
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

/// Returns true if many stops receive enough beacons for a pose and have no pose.
bool are_stops_without_place(const Solution& solution) {
  constexpr double kMany = 0.25;
  constexpr std::size_t kBeacons = 4;
  std::size_t stops = 0, without = 0;
  for (const Trajectory& t : solution.trajectories) {
    if (t.moving) continue;
    for (const Segment& s : t.segments) {
      std::set<BeaconId> heard;
      for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
        if (t.arrivals[i].rejection != Rejection::kBeaconUnusable) heard.insert(t.arrivals[i].beacon);
      if (heard.size() < kBeacons) continue;
      ++stops;
      without += !t.nodes[s.first_node].placed;
    }
  }
  return static_cast<double>(without) > kMany * static_cast<double>(stops);
}

/// Ratio of the estimated noise of the arrivals to the noise in the site file.
double noise_ratio(const Problem& problem, const Solution& solution) {
  return problem.site.noise.tof_sigma_s > 0 ? solution.tof_sigma_s / problem.site.noise.tof_sigma_s : 1.0;
}

/// Returns true if errors common to many observations explain everything.
bool is_explained(const Solution& solution) {
  constexpr double kNoiseOfAll = 1.5;
  return !solution.common_errors.empty() && solution.contradictions.size() <= solution.common_errors.size() &&
         solution.common_errors.front().noise_left < kNoiseOfAll;
}

/// Reports a misfit that no error explains. Noise is rarely misjudged so much, and less than this if
/// residuals are correlated, which noise is not.
std::optional<Contradiction> unexplained_misfit(const Problem& problem, const Solution& solution) {
  constexpr double kMisfit = 10.0, kCorrelatedMisfit = 5.0;
  const double ratio = noise_ratio(problem, solution);
  const bool is_correlated = solution.errors.correlated;
  if (solution.status != SolveStatus::kConverged || !(ratio > (is_correlated ? kCorrelatedMisfit : kMisfit)))
    return {};
  return Contradiction{
      ContradictionKind::kLog,
      "as a whole",
      fmt::format("with noise of {:.3g} us", 1e6 * problem.site.noise.tof_sigma_s),
      fmt::format("residuals of {:.3g} us{}, a variance factor of {:.3g} that no single cause explains",
                  1e6 * solution.tof_sigma_s, is_correlated ? ", alike from one arrival to the next" : "",
                  solution.statistics.variance_factor),
      0.0,
      "check the positions of control points, the wiring, units, frames and clocks; if the noise is really "
      "so large, state noise.tof_sigma_s as it is"};
}

/// Reports stops that receive enough beacons and have no pose: their arrivals contradict an assumption.
std::optional<Contradiction> stops_without_place(const Solution& solution) {
  if (solution.status != SolveStatus::kConverged || !are_stops_without_place(solution)) return {};
  return Contradiction{ContradictionKind::kLog,
                       "as a whole",
                       "of one vehicle among the stated positions",
                       "more than a quarter of the stops that receive four or more beacons to agree with no "
                       "place of the vehicle",
                       0.0,
                       "check what changes in the recording from the first of these stops on, and calibrate "
                       "with the part before it"};
}

/// Reports that many arrivals are rejected, many of them early. These are no echoes, so some assumption is
/// wrong.
std::optional<Contradiction> many_early(const Problem& problem, const Solution& solution) {
  constexpr double kMuchLeftOut = 0.3, kMuchEarly = 0.1;
  if (solution.status != SolveStatus::kConverged) return {};
  const RejectionCounts n = arrivals_by_outcome(problem, solution);
  const auto rows = static_cast<double>(n.all());
  const std::size_t early = n.of(Rejection::kEarly);
  if (static_cast<double>(n.outliers()) < kMuchLeftOut * rows ||
      static_cast<double>(early) < kMuchEarly * rows)
    return {};
  return Contradiction{ContradictionKind::kLog,
                       "as a whole",
                       "heard along straight paths",
                       fmt::format("{} of {} arrivals not to fit, {} of them early, as no echo can be",
                                   n.outliers(), n.all(), early),
                       0.0,
                       "check the positions of control points and receivers, their wiring, and labels, units "
                       "and frames; then calibrate again"};
}

}  // namespace

bool seems_misread(const Problem& problem, const Solution& solution) {
  const RejectionCounts n = arrivals_by_outcome(problem, solution);
  const std::size_t early = n.of(Rejection::kEarly);
  if (n.all() == 0 || solution.status == SolveStatus::kInterrupted) return false;
  // Without a scale the calibration is refused before the arrivals are compared with anything.
  if (solution.status == SolveStatus::kUndetermined && solution.trajectories.empty()) return false;
  if (solution.status == SolveStatus::kNotConverged || solution.beacon_status.empty())
    return true;  // there is no solution
  if (early >= kEarlyAtLeast && static_cast<double>(early) > kEarlyShare * static_cast<double>(n.all()))
    return true;
  if (are_many_left_out(problem, solution)) return true;
  return noise_ratio(problem, solution) >
             (solution.errors.correlated ? kCorrelatedNoiseRatio : kNoiseRatio) ||
         are_stops_without_place(solution) || is_dragged(problem, solution);
}

namespace {

/// Searches for another false assumption. If one is found, it replaces the contradictions found before.
void search(const Problem& problem, const Problem& adjusted, Solution& solution,
            const SolveOptions& options) {
  const bool misread = seems_misread(adjusted, solution);
  if (!misread && solution.contradictions.empty() && !do_poses_tumble(problem.runs)) return;
  std::vector<Contradiction> found;
  const bool was_cut_short = std::exchange(solution.diagnosis.is_cut_short, false);
  diagnose_within_budget(options, solution, 1.0, [&](const SolveOptions& limited) {
    found = misread ? find_misreadings(problem, solution, limited)
                    : find_other_culprits(problem, solution, limited);
  });
  if (!found.empty()) {  // The result of the earlier steps is replaced, so their time limit does not matter.
    solution.contradictions = std::move(found);
    return;
  }
  solution.diagnosis.is_cut_short |= was_cut_short;
  if (solution.contradictions.empty()) {
    auto whole = many_early(adjusted, solution);
    if (!whole) whole = unexplained_misfit(adjusted, solution);
    if (!whole) whole = stops_without_place(solution);
    if (whole) solution.contradictions.push_back(std::move(*whole));
  }
}

void explain_misfit(const Problem& problem, const Problem& adjusted, Solution& solution,
                    const SolveOptions& options) {
  if (!is_explained(solution)) search(problem, adjusted, solution, options);
  if (solution.status != SolveStatus::kUndetermined) return;
  if (!solution.contradictions.empty()) {
    solution.message = "the recordings do not fit what was stated, and nothing is exported";
    solution.weak.clear();
  } else if (const double ratio = noise_ratio(adjusted, solution); ratio > kNoiseRatio) {
    // The sigmas are large because nothing agrees. More recordings of this kind would not help.
    solution.message = fmt::format(
        "the arrivals do not fit what was stated: residuals are {:.3g} times as large as stated, and no "
        "single error that was tried explains them; nothing is exported",
        ratio);
    solution.weak.clear();
  }
}

}  // namespace

void explain(const Problem& problem, const Problem& adjusted, Solution& solution,
             const SolveOptions& options) {
  explain_misfit(problem, adjusted, solution, options);
  if (!solution.diagnosis.is_cut_short) return;
  solution.warnings.push_back(
      fmt::format("The search for what contradicts the data ended after {:.1f} s of processor time, before "
                  "all hypotheses were "
                  "examined. The "
                  "calibration is complete, but its cause of a misfit may be another one.",
                  solution.diagnosis.spent_s));
}

}  // namespace octant::calib
