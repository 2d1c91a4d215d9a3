// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/chunks/chunk_subsample.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "calib/problem/subsample.h"
#include "calib/stream/chunks/state_bearings.h"
#include "calib/stream/long_log.h"
#include "models/support/parallel.h"

namespace octant::calib {
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

/// Result of each block of a list, read in parallel.
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

/// Chooses further epochs for beacons that the chosen ones receive too rarely.
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
  // All of these epochs, with a limited number of arrivals of one pair in each.
  SubsampleOptions all = kLongLogSubsample;
  all.instants = index.states(run);
  all.per_beacon = 0;
  return subsample(sample, site, all);
}

}  // namespace octant::calib
