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
#include "calib/verdict/left_out.h"

namespace octant::calib {
namespace {

/// How an outcome looks that is worth a search.
constexpr double kEarlyShare = 0.05, kNoiseRatio = 3.0, kDraggedSigmas = 6.0;
/// Noise over the stated one where residuals are alike from one arrival to the next: more than bad weather.
constexpr double kCorrelatedNoiseRatio = 1.5;
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

/// Stops that hear enough beacons for a place, and have none.
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

/// Noise of the arrivals over the stated one.
double noise_ratio(const Problem& problem, const Solution& solution) {
  return problem.site.noise.tof_sigma_s > 0 ? solution.tof_sigma_s / problem.site.noise.tof_sigma_s : 1.0;
}

/// Errors that many observations have in common have explained all.
bool is_explained(const Solution& solution) {
  constexpr double kNoiseOfAll = 1.5;
  return !solution.contradictions.empty() &&
         solution.contradictions.size() <= solution.common_errors.size() &&
         solution.common_errors.front().noise_left < kNoiseOfAll;
}

/// A misfit that no error explains is no noise: nobody states the noise so wrongly, and noise is white.
std::optional<Contradiction> unexplained_misfit(const Problem& problem, const Solution& solution) {
  constexpr double kMisfit = 5.0;
  const double ratio = noise_ratio(problem, solution);
  if (solution.status != SolveStatus::kConverged || !solution.errors.correlated || ratio < kMisfit) return {};
  return Contradiction{
      ContradictionKind::kLog,
      "as a whole",
      "as precise as the site file has it",
      fmt::format("residuals {:.3g} times as large, alike from one arrival to the next, which no "
                  "single error that was tried explains",
                  ratio),
      0.0,
      "compare the recording with the site file line by line, or record a short run at "
      "known places and calibrate with that alone"};
}

/// Where stops that receive enough beacons have no place, their arrivals contradict what was stated.
std::optional<Contradiction> stops_without_place(const Solution& solution) {
  if (solution.status != SolveStatus::kConverged || !are_stops_without_place(solution)) return {};
  return Contradiction{ContradictionKind::kLog,
                       "as a whole",
                       "of one vehicle among the stated positions",
                       "more than a quarter of the stops that receive four or more beacons to agree with no "
                       "place of the vehicle",
                       0.0,
                       "look at how the recording changes from the first of these stops on, and calibrate "
                       "with the part before it"};
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
  return noise_ratio(problem, solution) >
             (solution.errors.correlated ? kCorrelatedNoiseRatio : kNoiseRatio) ||
         are_stops_without_place(solution) || is_dragged(problem, solution);
}

namespace {

/// Looks for what else may be false. Where something is, that takes the place of what was found before.
void search(const Problem& problem, const Problem& adjusted, Solution& solution,
            const SolveOptions& options) {
  const bool misread = seems_misread(adjusted, solution);
  if (!misread && solution.contradictions.empty() && !do_poses_tumble(problem.runs)) return;
  std::vector<Contradiction> found = misread ? find_misreadings(problem, solution, options)
                                             : find_other_culprits(problem, solution, options);
  if (!found.empty()) {
    solution.contradictions = std::move(found);
  } else if (solution.contradictions.empty()) {
    auto whole = early_beyond_chance(adjusted, solution);
    if (!whole) whole = unexplained_misfit(adjusted, solution);
    if (!whole) whole = stops_without_place(solution);
    if (whole) solution.contradictions.push_back(std::move(*whole));
  }
}

}  // namespace

void explain(const Problem& problem, const Problem& adjusted, Solution& solution,
             const SolveOptions& options) {
  if (!is_explained(solution)) search(problem, adjusted, solution, options);
  if (solution.status != SolveStatus::kUndetermined) return;
  if (!solution.contradictions.empty()) {
    solution.message = "the recordings do not fit what was stated, and nothing is exported";
    solution.weak.clear();
  } else if (const double ratio = noise_ratio(adjusted, solution); ratio > kNoiseRatio) {
    // Sigmas are so large because nothing fits, and more recordings of this kind would not help.
    solution.message = fmt::format(
        "the arrivals do not fit what was stated: residuals are {:.3g} times as large as stated, and no "
        "single error that was tried explains them; nothing is exported",
        ratio);
    solution.weak.clear();
  }
}

}  // namespace octant::calib
