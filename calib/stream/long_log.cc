// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/long_log.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/adjust/reject.h"
#include "calib/adjust/tile_sum.h"
#include "calib/start/start.h"
#include "calib/stream/chunks/state_bearings.h"
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
/// States of which each stands alone at a measured pose, in the plane or in space.
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

/// Reads the epochs that begin in a block: visit(epoch's number, arrival).
template <class Visit>
Result<void> for_each_row_of_block(const ArrivalSource& source, const ChunkIndex& index, std::size_t run,
                                   std::size_t block, Visit&& visit) {
  std::vector<Arrival> rows;
  if (auto ok = index.read(source, run, block, block + 1, rows); !ok) return ok;
  struct CurrentEpoch {
    VehicleId vehicle;
    std::int64_t epoch;
    std::size_t number;
  };
  std::vector<CurrentEpoch> current;  // of each vehicle met
  std::size_t next = index.first_state(run, block);
  for (const Arrival& a : rows) {
    auto at = std::ranges::find(current, a.vehicle, &CurrentEpoch::vehicle);
    if (at == current.end())
      at = current.insert(at, {a.vehicle, a.epoch, next++});
    else if (at->epoch != a.epoch)
      *at = {a.vehicle, a.epoch, next++};
    visit(at->number, a);
  }
  return {};
}

/// What each block of a list gives, read side by side.
template <class Found, class Read>
Result<std::vector<Found>> read_blocks(const std::vector<std::size_t>& blocks, int threads, Read&& read) {
  std::vector<Found> found;
  std::vector<std::vector<Found>> of_block(blocks.size());
  std::vector<std::optional<Error>> wrong(blocks.size());
  for_each_parallel(blocks.size(), threads, [&](std::size_t i) {
    if (auto ok = read(blocks[i], of_block[i]); !ok) wrong[i] = ok.error();
  });
  for (const auto& error : wrong)
    if (error) return fail(*error);
  for (const auto& some : of_block) found.insert(found.end(), some.begin(), some.end());
  return found;
}

/// Chooses more epochs for the beacons that the chosen ones hear too seldom, of those that hear them.
Result<void> choose_for_rare_beacons(const ArrivalSource& source, const ChunkIndex& index, std::size_t run,
                                     int threads, GroupsHearing& hearing, std::vector<bool>& chosen) {
  struct HeardBeacon {
    std::size_t epoch, beacon;
  };
  std::vector<bool> rare(hearing.kept.size());
  for (std::size_t b = 0; b < rare.size(); ++b)
    rare[b] = hearing.kept[b] < kLongLogSubsample.per_beacon && hearing.kept[b] < index.heard(run)[b];
  if (std::ranges::find(rare, true) == rare.end()) return {};
  std::vector<std::size_t> blocks(index.blocks(run));
  for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b] = b;
  auto heard =
      read_blocks<HeardBeacon>(blocks, threads, [&](std::size_t block, std::vector<HeardBeacon>& out) {
        return for_each_row_of_block(source, index, run, block, [&](std::size_t epoch, const Arrival& a) {
          if (rare[a.beacon.index()] && !chosen[epoch]) out.push_back({epoch, a.beacon.index()});
        });
      });
  if (!heard) return fail(heard.error());
  std::ranges::stable_sort(*heard, {}, &HeardBeacon::epoch);
  hearing.more.resize(rare.size());
  for (const HeardBeacon& h : *heard)
    if (hearing.more[h.beacon].empty() || hearing.more[h.beacon].back() != h.epoch)
      hearing.more[h.beacon].push_back(h.epoch);
  // Only of rare beacons, as all others have enough.
  hearing.for_each_heard = [&heard](std::size_t epoch, const auto& visit) {
    const auto before = [](const HeardBeacon& h, std::size_t e) { return h.epoch < e; };
    for (auto at = std::lower_bound(heard->begin(), heard->end(), epoch, before);
         at != heard->end() && at->epoch == epoch; ++at)
      visit(at->beacon);
  };
  choose_more(hearing, kLongLogSubsample.per_beacon, chosen);
  return {};
}

/// Arrivals of the chosen epochs that are not yet in the log.
Result<void> read_epochs(const ArrivalSource& source, const ChunkIndex& index, std::size_t run,
                         const std::vector<bool>& chosen, int threads, std::vector<Arrival>& arrivals) {
  std::vector<std::size_t> blocks;
  for (std::size_t b = 0; b < index.blocks(run); ++b) {
    const auto begin = chosen.begin() + static_cast<std::ptrdiff_t>(index.first_state(run, b));
    const auto end = chosen.begin() + static_cast<std::ptrdiff_t>(index.first_state(run, b + 1));
    if (std::find(begin, end, true) != end) blocks.push_back(b);
  }
  auto some = read_blocks<Arrival>(blocks, threads, [&](std::size_t block, std::vector<Arrival>& out) {
    return for_each_row_of_block(source, index, run, block, [&](std::size_t epoch, const Arrival& a) {
      if (chosen[epoch]) out.push_back(a);
    });
  });
  if (!some) return fail(some.error());
  arrivals.insert(arrivals.end(), some->begin(), some->end());
  return {};
}

}  // namespace

Result<MeasurementLog> subsample_of_stops(std::size_t run, const Site& site, const ArrivalSource& source,
                                          const ChunkIndex& index, int threads) {
  MeasurementLog sample = without_lists(source.log(run));
  sample.rejected = source.log(run).rejected;
  std::vector<bool> chosen = evenly_chosen(index.states(run), kLongLogSubsample.instants);
  if (auto ok = read_epochs(source, index, run, chosen, threads, sample.arrivals); !ok)
    return fail(ok.error());
  GroupsHearing hearing;
  hearing.kept.assign(site.beacons.size(), 0);
  for (const Arrival& a : sample.arrivals) ++hearing.kept[a.beacon.index()];
  std::vector<bool> more = chosen;
  if (auto ok = choose_for_rare_beacons(source, index, run, threads, hearing, more); !ok)
    return fail(ok.error());
  for (std::size_t e = 0; e < more.size(); ++e) more[e] = more[e] && !chosen[e];
  if (auto ok = read_epochs(source, index, run, more, threads, sample.arrivals); !ok) return fail(ok.error());
  sort_by_time(sample.arrivals);
  std::vector<std::pair<double, double>> spans;
  for (const Arrival& a : sample.arrivals) spans.emplace_back(a.time_s, a.time_s);
  sample.poses = poses_near(source.log(run).poses, spans);
  const std::vector<Bearing>& bearings = source.log(run).bearings;
  for (const std::size_t b : StateBearings(bearings, index.kinds(run)).of_states_in(sample.arrivals))
    sample.bearings.push_back(bearings[b]);
  // All of these epochs, but not more of one pair within one than is good for anything.
  SubsampleOptions all = kLongLogSubsample;
  all.instants = index.states(run);
  all.per_beacon = 0;
  return subsample(sample, site, all);
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
    // A state that a measured pose placed is off by the error of that, not by the noise of its arrivals.
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
