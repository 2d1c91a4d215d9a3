// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/clock_jumps.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/adjust/reject.h"
#include "calib/problem/clock_check.h"
#include "calib/problem/ranges.h"
#include "calib/problem/subsample.h"
#include "calib/start/approach.h"
#include "calib/start/start.h"
#include "calib/statements/common_errors.h"
#include "models/localizers/least_squares/epoch_fix.h"

namespace octant::calib {
namespace {

/// Subsamples: of the adjusted half, and of the stops whose clock offsets are estimated from it.
constexpr SubsampleOptions kHalf = {.instants = 40, .per_beacon = 30, .per_pair = 4};
constexpr SubsampleOptions kAllStops = {.instants = 400, .per_beacon = 0, .per_pair = 4};
/// Sigma of ranges along a drive. It is large, so that odometry carries the states across a jump.
constexpr double kLooseRangeM = 0.3;
/// Uncertainty of ranges to beacons that one half determines, for vehicle positions of the other half.
constexpr double kOtherHalfUncertaintyM = 0.1;
/// Least size of a jump. Jumps are found by their significance, and it is examined later if they explain the
/// recording.
constexpr double kSmallestJumpM = 0.01;
/// Maximum number of arrivals between two estimates of the time of one jump.
constexpr std::ptrdiff_t kSameJump = 128;
/// Steps below this share of a known jump are distortions that the jump caused in the adjusted half.
constexpr double kBesides = 0.25;
/// Maximum number of jumps in one recording. More have another cause.
constexpr std::size_t kMostJumps = 5;

MeasurementLog half_of(const MeasurementLog& run, LogHalf half) {
  std::vector<double> times;
  times.reserve(run.arrivals.size());
  for (const Arrival& a : run.arrivals) times.push_back(a.time_s);
  const double middle_s = median(std::move(times));
  MeasurementLog part = run;
  std::erase_if(part.arrivals,
                [&](const Arrival& a) { return (a.time_s < middle_s) != (half == LogHalf::kFirst); });
  return part;
}

/// Trajectories of the run, solved for the beacon positions in `adjusted`.
/// @param solve_states  bool(Trajectory&, const EpochFixModel&, const SharedState&); false omits the
/// trajectory
template <class Solve>
std::vector<Trajectory> solved_by(Site site, const MeasurementLog& run, const Estimate& adjusted, int threads,
                                  Solve solve_states) {
  MeasurementLog some = subsample(run, site, kAllStops);
  auto problem = make_problem(std::move(site), {std::move(some)}, threads);
  if (!problem) return {};
  const SharedState state = adjusted.state();
  const EpochFixModel model = search_model(*problem, state, adjusted.beacon_usable);
  std::erase_if(problem->trajectories, [&](Trajectory& t) { return !solve_states(t, model, state); });
  return std::move(problem->trajectories);
}

/// Stops of the run, each with its own clock offset.
std::vector<Trajectory> stops_with_clocks(const Site& site, const MeasurementLog& run,
                                          const Estimate& adjusted, int threads) {
  Site loose = site;
  loose.timing.clock = Clock::kCycleOffset;
  return solved_by(std::move(loose), run, adjusted, threads,
                   [&](Trajectory& t, const EpochFixModel& model, const SharedState&) {
                     static_cast<void>(place_states(t, model, kOtherHalfUncertaintyM, false, 0.0, threads));
                     t.has_cycle_offset = false;  // the estimated offset is not one of the site's clock model
                     return true;
                   });
}

/// Drives of the run, solved by odometry and ranges of low weight.
std::vector<Trajectory> drives_by_loose_ranges(const Site& site, const MeasurementLog& run,
                                               const Estimate& adjusted, int threads) {
  const double loose_s = kLooseRangeM / speed_mps(site.medium);
  const auto by_odometry = [&](Trajectory& t, const EpochFixModel& model, const SharedState& state) {
    if (!t.moving) return false;
    static_cast<void>(place_states(t, model, kLooseRangeM, false, 0.0, threads));
    if (std::ranges::any_of(t.nodes, [](const Node& node) { return !node.placed; })) return false;
    for (ArrivalObservation& a : t.arrivals) a.sigma_s = std::max(a.sigma_s, loose_s);
    for (const Segment& segment : t.segments) {
      reset_rejections(t, segment, model);
      static_cast<void>(solve_states(t, segment, state, RobustLoss{kCauchyScale, kCauchyScale}));
    }
    return true;
  };
  return solved_by(site, run, adjusted, threads, by_odometry);
}

/// Steps of the clock in the run for the beacon positions that one half determines; empty if it determines
/// none.
std::vector<ClockStep> jumps_by(const Site& site, const MeasurementLog& half, const MeasurementLog& run,
                                const SolveOptions& options) {
  const auto problem = make_problem(site, {subsample(half, site, kHalf)}, options.threads);
  if (!problem) return {};
  ProgressMonitor monitor(options);
  const Approach found = approach(*problem, options, monitor, false);
  if (!found.ok) return {};
  if (!run.has_epochs)
    return steps_along_drives(drives_by_loose_ranges(site, run, found.estimate, options.threads),
                              found.estimate.state(), kSmallestJumpM);
  return steps_between_stops(stops_with_clocks(site, run, found.estimate, options.threads), 0,
                             found.estimate.state(), kSmallestJumpM);
}

/// Finds the jump of which a step is the remainder; null if the step is a separate jump.
ClockStep* same_jump(const ClockStep& left, const MeasurementLog& run, std::vector<ClockStep>& jumps) {
  const auto is_same = [&](const ClockStep& jump) {
    const auto span = std::minmax(jump.time_s, left.time_s);
    const auto between = std::ranges::count_if(
        run.arrivals, [&](const Arrival& a) { return a.time_s >= span.first && a.time_s < span.second; });
    return between <= kSameJump;
  };
  const auto same = std::ranges::find_if(jumps, is_same);
  return same == jumps.end() ? nullptr : &*same;
}

bool is_smaller(const ClockStep& a, const ClockStep& b) { return std::abs(a.step_s) < std::abs(b.step_s); }

/// Adds the remaining steps to known jumps, and the largest of the other steps as a new jump. The distortion
/// by a jump causes further steps, which disappear with it.
/// @return true if a jump was added
bool add(const std::vector<ClockStep>& left, const MeasurementLog& run, std::vector<ClockStep>& jumps) {
  std::vector<ClockStep> others;
  for (const ClockStep& step : left)
    if (ClockStep* same = same_jump(step, run, jumps); same != nullptr) {
      same->step_s += step.step_s;
    } else {
      others.push_back(step);
    }
  const auto largest = std::ranges::max_element(others, is_smaller);
  const auto known = std::ranges::max_element(jumps, is_smaller);
  if (largest == others.end() ||
      (known != jumps.end() && std::abs(largest->step_s) < kBesides * std::abs(known->step_s)))
    return false;
  jumps.push_back(*largest);
  return true;
}

}  // namespace

std::vector<ClockStep> clock_jumps(const Site& site, const MeasurementLog& run, LogHalf half,
                                   const SolveOptions& options) {
  const bool is_drive = !run.has_epochs && !run.odometry.empty();
  if (!(run.has_epochs || is_drive) || run.arrivals.empty() || site.timing.clock == Clock::kCycleOffset)
    return {};
  // A jump distorts the solution in which it is measured. Jumps are therefore corrected one after the other,
  // the largest first by the ranges alone, and the remainder is measured again.
  std::vector<ClockStep> jumps = steps_in_ranges(site, run);
  for (std::size_t round = 0; round < kMostJumps; ++round) {
    MeasurementLog rest = run;
    without_jumps(jumps, rest);
    if (!add(jumps_by(site, half_of(rest, half), rest, options), run, jumps)) break;
  }
  std::ranges::sort(jumps, {}, &ClockStep::time_s);
  return jumps;
}

void without_jumps(const std::vector<ClockStep>& jumps, MeasurementLog& run) {
  for (Arrival& a : run.arrivals)
    for (const ClockStep& jump : jumps)
      if (a.time_s >= jump.time_s) a.tof_s -= jump.step_s;
}

namespace {

/// Clock offsets of evenly spread stops of a run, in order of time.
std::vector<std::pair<double, double>> offsets_of_stops(const Site& site, const MeasurementLog& run,
                                                        const SolveOptions& options) {
  Site loose = site;
  loose.timing.clock = Clock::kCycleOffset;
  const auto problem = make_problem(loose, {subsample(run, site, kHalf)}, options.threads);
  if (!problem) return {};
  ProgressMonitor monitor(options);
  const Approach found = approach(*problem, options, monitor, false);
  std::vector<std::pair<double, double>> offsets;
  if (!found.ok) return offsets;
  for (const Trajectory& t : found.trajectories)
    for (const Node& node : t.nodes)
      if (node.placed) offsets.emplace_back(node.time_s, node.cycle_offset_s);
  std::ranges::sort(offsets);
  return offsets;
}

/// Growth of the offsets from the first to the last, from the median of the slopes of all pairs (Theil 1950,
/// Sen 1968). No value if they scatter about that line by too large a share of the growth.
std::optional<double> growth_of(const std::vector<std::pair<double, double>>& offsets) {
  constexpr std::size_t kFewest = 8;
  constexpr double kScatter = 0.1;  // of the growth
  if (offsets.size() < kFewest) return {};
  const double span_s = offsets.back().first - offsets.front().first;
  std::vector<double> slopes, starts, off;
  for (std::size_t i = 0; i < offsets.size(); ++i)
    for (std::size_t j = i + 1; j < offsets.size(); ++j)
      if (offsets[j].first > offsets[i].first)
        slopes.push_back((offsets[j].second - offsets[i].second) / (offsets[j].first - offsets[i].first));
  const double slope = median(std::move(slopes));
  for (const auto& [time_s, offset_s] : offsets) starts.push_back(offset_s - slope * time_s);
  const double start_s = median(starts);
  for (const double s : starts) off.push_back(std::abs(s - start_s));
  const double growth_s = slope * span_s;
  if (median(std::move(off)) > kScatter * std::abs(growth_s)) return {};
  return growth_s;
}

}  // namespace

std::vector<Reading> drifting_clocks(const Site& site, const std::vector<MeasurementLog>& runs,
                                     const SolveOptions& options) {
  std::vector<Reading> readings;
  if (site.timing.clock == Clock::kCycleOffset) return readings;
  for (std::size_t run = 0; run < runs.size(); ++run) {
    if (!runs[run].has_epochs) continue;
    const std::optional<double> growth_s = growth_of(offsets_of_stops(site, runs[run], options));
    if (!growth_s) continue;
    const CommonError drift{.kind = CommonError::Kind::kDrift, .run = run, .size = *growth_s};
    readings.push_back({contradiction_of(drift, site, runs),
                        {},
                        [drift, span_s = span_of(runs[run].arrivals)](std::size_t of, MeasurementLog& log) {
                          if (of == drift.run) take_back(drift, span_s, log);
                        }});
  }
  return readings;
}

std::vector<Reading> jumped_clocks(const Site& site, const std::vector<MeasurementLog>& runs,
                                   const SolveOptions& options) {
  std::vector<Reading> readings;
  for (const LogHalf half : {LogHalf::kFirst, LogHalf::kLast}) {
    std::vector<std::vector<ClockStep>> jumps;
    std::vector<std::string> names, words;
    for (const MeasurementLog& run : runs) {
      jumps.push_back(clock_jumps(site, run, half, options));
      if (jumps.back().empty()) continue;
      names.push_back(run.path);
      for (const ClockStep& jump : jumps.back()) words.push_back(jump_in_words(jump.time_s, jump.step_s));
    }
    if (names.empty()) continue;
    Contradiction what = contradiction_of({.kind = CommonError::Kind::kJump}, site, runs);
    what.subject = fmt::format("{}", fmt::join(names, ", "));
    what.found = fmt::format("that it jumped: {}", fmt::join(words, ", "));
    readings.push_back({std::move(what), {}, [jumps](std::size_t run, MeasurementLog& log) {
                          without_jumps(jumps[run], log);
                        }});
  }
  return readings;
}

}  // namespace octant::calib
