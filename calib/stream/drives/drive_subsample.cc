// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drives/drive_subsample.h"

#include <algorithm>
#include <set>
#include <utility>

#include "calib/problem/subsample.h"
#include "calib/stream/long_log.h"

namespace octant::calib {
namespace {

/// @return whether any was left out
bool keep_some_of_pairs(std::size_t per_pair, std::vector<Arrival>& arrivals) {
  std::vector<const Arrival*> rows;
  for (const Arrival& a : arrivals) rows.push_back(&a);
  std::vector<Arrival> some;
  for (const std::size_t i : some_of_pairs(rows, per_pair)) some.push_back(arrivals[i]);
  const bool any_left_out = some.size() < arrivals.size();
  arrivals = std::move(some);
  return any_left_out;
}

}  // namespace

Result<MeasurementLog> subsample_of_drives(std::size_t run, const Site& site, const ArrivalSource& source,
                                           const DriveIndex& index) {
  const MeasurementLog& log = source.log(run);
  const DriveGroups& of_run = index.groups(run);
  MeasurementLog sample = without_lists(log);
  sample.rejected = log.rejected;
  const std::size_t beacons = index.beacons(),
                    budget = stretches_kept(site, kLongLogSubsample, of_run.arrivals, of_run.groups.size());
  const std::vector<bool> chosen =
      chosen_groups(of_run.groups.size(), beacons, budget, kLongLogSubsample.per_beacon,
                    [&](std::size_t g, const auto& visit) {
                      for (std::size_t b = 0; b < beacons; ++b)
                        for (std::uint32_t i = of_run.heard[g * beacons + b]; i > 0; --i) visit(b);
                    });
  std::vector<std::pair<double, double>> spans;
  std::vector<Arrival> rows;
  std::set<std::pair<VehicleId, std::int64_t>> chosen_keys;
  bool crowded = false;
  for (std::size_t g = 0; g < chosen.size(); ++g) {
    if (!chosen[g]) continue;
    if (auto ok = index.read(source, run, of_run.groups[g], rows); !ok) return fail(ok.error());
    crowded = keep_some_of_pairs(kLongLogSubsample.per_pair, rows) || crowded;
    sample.arrivals.insert(sample.arrivals.end(), rows.begin(), rows.end());
    double asked_s = 0.0;  // before the first of them
    for (const Arrival& a : rows) asked_s = std::max(asked_s, asked_before_s(site, a));
    chosen_keys.emplace(of_run.groups[g].vehicle, of_run.groups[g].key);
    spans.emplace_back(of_run.groups[g].first_s - asked_s, of_run.groups[g].last_s);
  }
  sort_by_time(sample.arrivals);
  if (of_run.groups.size() <= budget && !crowded) {  // all of it
    sample.odometry = log.odometry;
    sample.poses = log.poses;
    sample.bearings = log.bearings;
    return sample;
  }
  for (const Bearing& b : log.bearings)
    if (chosen_keys.count({b.vehicle, of_run.key_at(b.time_s)}) > 0) sample.bearings.push_back(b);
  std::ranges::sort(spans);
  sample.odometry = subsampled_odometry(log.odometry, spans);
  sample.poses = poses_near(log.poses, spans);
  return sample;
}

}  // namespace octant::calib
