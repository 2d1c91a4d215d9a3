// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/long_log.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/adjust/reject.h"
#include "calib/adjust/tile_sum.h"
#include "calib/start/start.h"
#include "models/localizers/least_squares/linear_ranges.h"
#include "models/support/parallel.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

constexpr std::size_t kLongEpochs = 4000;
constexpr std::size_t kLongDrive = 20'000;  ///< arrivals, or states whose pose was measured

bool is_placed_by_ranges(const Trajectory& t) {
  return t.motion == Motion::kPlanar && !t.has_cycle_offset && t.poses.empty();
}
bool has_stops(const Trajectory& t) { return !t.moving && t.odometry.empty(); }
/// Separate states at measured poses, in the plane or in space.
bool has_posed_states(const Trajectory& t) {
  return !t.poses.empty() && t.odometry.empty() && t.motion_steps.empty() && !t.has_cycle_offset;
}
bool is_drive(const Trajectory& t) { return t.moving && !t.odometry.empty(); }

}  // namespace

bool is_long(const Problem& problem) {
  std::size_t epochs = 0, of_drives = 0;
  for (const Trajectory& t : problem.trajectories) {
    if (has_stops(t)) {
      epochs += t.nodes.size();
    } else if (is_drive(t)) {
      of_drives += t.arrivals.size();
    } else if (has_posed_states(t)) {
      of_drives += t.nodes.size();
    } else {
      return false;
    }
  }
  return epochs > kLongEpochs || of_drives > kLongDrive;
}

bool has_stops_alone(const Problem& problem) { return std::ranges::all_of(problem.trajectories, has_stops); }

Result<Problem> subsample_of(const Problem& problem, int threads) {
  std::vector<MeasurementLog> runs;
  for (const MeasurementLog& run : problem.runs)
    runs.push_back(subsample(run, problem.site, kLongLogSubsample));
  return make_problem(problem.site, std::move(runs), threads);
}

namespace {

/// Linear ranges, solved in lanes; epochs in which an arrival then disagrees by more than `suspect_sigmas`
/// are searched as any other. Marks all arrivals used.
void place_all_stops(const Problem& problem, const ParameterLayout& layout, const SharedState& state,
                     const std::vector<bool>& usable, double suspect_sigmas, const Workers& workers,
                     std::vector<Trajectory>& trajectories) {
  constexpr std::size_t kSegmentsAtOnce = 1024;
  for (Trajectory& t : trajectories)
    for_each_in_chunks(t.segments.size(), kSegmentsAtOnce, workers.threads, [&](std::size_t s) {
      if (is_placed_by_ranges(t))
        t.nodes[t.segments[s].first_node].placed = place_by_linear_ranges(t, t.segments[s], state, usable);
    });
  readmit_all(trajectories, usable);
  {
    TileSum tiles(trajectories, layout, workers);
    static_cast<void>(tiles.solve_states(state, {kCauchyScale, kCauchyScale}));
    tiles.commit();
    tiles.share_states();
  }
  const EpochFixModel model = search_model(problem, state, usable);
  for (Trajectory& t : trajectories) {
    for_each_in_chunks(t.segments.size(), kSegmentsAtOnce, workers.threads, [&](std::size_t k) {
      const Segment& s = t.segments[k];
      Node& node = t.nodes[s.first_node];
      if (s.first_pose < s.last_pose) return;  // which no search places
      ArrivalResiduals residual_of(t, state);
      for (std::size_t i = s.first_arrival; i < s.last_arrival && node.placed; ++i)
        if (t.arrivals[i].rejection == Rejection::kUsed &&
            std::abs(residual_of(t.arrivals[i])) > suspect_sigmas)
          node.placed = false;
    });
    place_states(t, model, 0.0, false, 0.0, workers.threads);
  }
  readmit_all(trajectories, usable);
}

}  // namespace

void place_all_drives(const Problem& problem, const SharedState& state, const std::vector<bool>& usable,
                      int threads, std::vector<Trajectory>& trajectories) {
  constexpr std::size_t kSegmentsAtOnce = 1024;
  const EpochFixModel model = search_model(problem, state, usable);
  for (Trajectory& t : trajectories) place_states(t, model, 0.0, false, 0.0, threads);
  readmit_all(trajectories, usable);
  for (Trajectory& t : trajectories) {
    if (t.poses.empty()) continue;
    // The error of a state that a measured pose placed is that of the pose, not the noise of its arrivals.
    for_each_in_chunks(t.segments.size(), kSegmentsAtOnce, threads, [&](std::size_t s) {
      solve_states(t, t.segments[s], state, {kCauchyScale, kCauchyScale});
    });
  }
}

void place_all(const Problem& problem, const ParameterLayout& layout, const SharedState& state,
               const std::vector<bool>& usable, double suspect_sigmas, const Workers& workers,
               std::vector<Trajectory>& trajectories) {
  std::vector<Trajectory> stops, drives;
  std::vector<bool> drove;
  for (Trajectory& t : trajectories) {
    drove.push_back(t.moving || !t.odometry.empty());
    (drove.back() ? drives : stops).push_back(std::move(t));
  }
  if (!stops.empty()) place_all_stops(problem, layout, state, usable, suspect_sigmas, workers, stops);
  if (!drives.empty()) place_all_drives(problem, state, usable, workers.threads, drives);
  auto stop = stops.begin(), drive = drives.begin();
  for (std::size_t i = 0; i < trajectories.size(); ++i)
    trajectories[i] = std::move(drove[i] ? *drive++ : *stop++);
}

}  // namespace octant::calib
