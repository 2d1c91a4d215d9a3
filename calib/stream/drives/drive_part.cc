// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drives/drive_part.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "calib/problem/thin.h"
#include "calib/stream/long_log.h"

namespace octant::calib {
namespace {

/// At most so many arrivals of each pair, evenly, as thin() takes them. @return whether any was left out
bool keep_some_of_pairs(std::size_t per_pair, std::vector<Arrival>& arrivals) {
  using Pair = std::pair<int, int>;
  const auto pair_of = [](const Arrival& a) { return Pair(a.beacon.value, a.receiver.value); };
  std::map<Pair, std::size_t> all, met;
  for (const Arrival& a : arrivals) ++all[pair_of(a)];
  return std::erase_if(arrivals, [&](const Arrival& a) {
           const std::size_t n = all[pair_of(a)], count = std::min(n, per_pair), at = met[pair_of(a)]++,
                             i = (at * count + n - 1) / n;
           return i * n / count != at;
         }) > 0;
}

/// The groups that thin() takes of a run.
std::vector<bool> chosen_groups(const DriveGroups& of_run, std::size_t beacons, std::size_t budget) {
  const auto heard = [&](std::size_t g, std::size_t b) { return of_run.heard[g * beacons + b]; };
  std::vector<bool> chosen = evenly_chosen(of_run.groups.size(), budget);
  GroupsHearing hearing;
  hearing.kept.assign(beacons, 0);
  hearing.more.resize(beacons);
  for (std::size_t g = 0; g < chosen.size(); ++g)
    for (std::size_t b = 0; b < beacons; ++b) {
      if (chosen[g]) hearing.kept[b] += heard(g, b);
      if (!chosen[g] && heard(g, b) > 0) hearing.more[b].push_back(g);
    }
  hearing.for_each_heard = [&](std::size_t g, const auto& visit) {
    for (std::size_t b = 0; b < beacons; ++b)
      for (std::uint32_t i = 0; i < heard(g, b); ++i) visit(b);
  };
  choose_more(hearing, kPartOfLongLog.per_beacon, chosen);
  return chosen;
}

std::size_t budget_of(const DriveGroups& of_run, const DriveStretches& stretches) {
  if (of_run.groups.empty()) return kPartOfLongLog.instants;
  const double each = static_cast<double>(of_run.arrivals) / static_cast<double>(of_run.groups.size());
  return static_cast<std::size_t>(
      std::max(static_cast<double>(stretches.fewest),
               static_cast<double>(kPartOfLongLog.drive_arrivals) / std::max(each, 1e-3)));
}

}  // namespace

Result<MeasurementLog> part_of_drives(std::size_t run, const Site& site, const ArrivalSource& source,
                                      const DriveIndex& index) {
  const MeasurementLog& log = source.log(run);
  const DriveGroups& of_run = index.groups(run);
  MeasurementLog few = without_lists(log);
  few.rejected = log.rejected;
  const DriveStretches stretches = stretches_of(site);
  const bool two_way = site.timing.ranging == Ranging::kTwoWay;
  const std::size_t budget = budget_of(of_run, stretches);
  const std::vector<bool> chosen = chosen_groups(of_run, index.beacons(), budget);
  std::vector<std::pair<double, double>> spans;
  std::vector<Arrival> rows;
  std::set<std::pair<VehicleId, std::int64_t>> chosen_keys;
  bool crowded = false;
  for (std::size_t g = 0; g < chosen.size(); ++g) {
    if (!chosen[g]) continue;
    if (auto ok = index.read(source, run, of_run.groups[g], rows); !ok) return fail(ok.error());
    crowded = keep_some_of_pairs(std::min(stretches.per_pair, kPartOfLongLog.per_pair), rows) || crowded;
    few.arrivals.insert(few.arrivals.end(), rows.begin(), rows.end());
    double asked_s = 0.0;  // before the first of them
    for (const Arrival& a : rows) asked_s = std::max(asked_s, two_way ? a.tof_s : 0.0);
    chosen_keys.emplace(of_run.groups[g].vehicle, of_run.groups[g].key);
    spans.emplace_back(of_run.groups[g].first_s - asked_s, of_run.groups[g].last_s);
  }
  std::stable_sort(few.arrivals.begin(), few.arrivals.end(), [](const Arrival& a, const Arrival& b) {
    return a.time_s != b.time_s ? a.time_s < b.time_s : a.line < b.line;
  });
  if (of_run.groups.size() <= budget && !crowded) {  // all of it
    few.odometry = log.odometry;
    few.poses = log.poses;
    few.bearings = log.bearings;
    return few;
  }
  for (const Bearing& b : log.bearings)
    if (chosen_keys.count({b.vehicle, of_run.key_at(b.time_s)}) > 0) few.bearings.push_back(b);
  std::sort(spans.begin(), spans.end());
  few.odometry = thinned_odometry(log.odometry, spans);
  few.poses = poses_near(log.poses, spans);
  return few;
}

}  // namespace octant::calib
