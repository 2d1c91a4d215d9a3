// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pauses.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace octant::calib {
namespace {

constexpr std::size_t kFewestPauses = 3, kRowsPerPause = 4;
constexpr double kLongerThan = 3.0;  ///< ratio of a pause to the longest gap within a stop

/// Length of the shortest pause, by the widest step in the sorted gaps; 0 if no step is wide enough.
double pause_s(std::vector<double> gaps_s) {
  std::ranges::sort(gaps_s);
  const std::size_t most = gaps_s.size() / kRowsPerPause;
  double widest = kLongerThan, pause = 0.0;
  for (std::size_t count = kFewestPauses; count <= most; ++count) {
    const std::size_t i = gaps_s.size() - count;
    const double within_s = std::max(gaps_s[i - 1], 1e-3);
    if (gaps_s[i] <= widest * within_s) continue;
    widest = gaps_s[i] / within_s;
    pause = gaps_s[i];
  }
  return pause;
}

}  // namespace

std::size_t number_stops(MeasurementLog& run) {
  if (!run.odometry.empty() || !run.poses.empty() || run.arrivals.size() < kFewestPauses * kRowsPerPause)
    return 0;
  if (run.has_epochs && std::ranges::any_of(run.arrivals, [&](const Arrival& a) {
        return a.epoch != run.arrivals.front().epoch;
      }))
    return 0;
  std::map<VehicleId, double> last_s;
  std::vector<double> gaps_s;
  for (const Arrival& a : run.arrivals) {
    const auto [last, first] = last_s.try_emplace(a.vehicle, a.time_s);
    if (!first) gaps_s.push_back(a.time_s - last->second);
    last->second = a.time_s;
  }
  const double pause = pause_s(std::move(gaps_s));
  if (!(pause > 0)) return 0;
  std::map<VehicleId, std::pair<double, std::int64_t>> at;  // time of the last arrival, number of the stop
  std::size_t stops = 0;
  for (Arrival& a : run.arrivals) {
    const auto [latest, first] = at.try_emplace(a.vehicle, a.time_s, 0);
    if (!first && a.time_s - latest->second.first >= pause) ++latest->second.second;
    latest->second.first = a.time_s;
    a.epoch = latest->second.second;
    stops = std::max(stops, static_cast<std::size_t>(a.epoch) + 1);
  }
  for (Bearing& b : run.bearings) b.epoch = kNoEpoch;
  run.has_epochs = true;
  return stops;
}

std::vector<Reading> numbered_stops(const std::vector<MeasurementLog>& runs) {
  std::vector<std::string> names;
  std::size_t stops = 0;
  bool numbered = false;
  for (MeasurementLog run : runs) {
    const bool had_epochs = run.has_epochs;
    const std::size_t found = number_stops(run);
    if (found == 0) continue;
    stops += found;
    numbered = numbered || had_epochs;
    names.push_back(run.path + "/tof.csv");
  }
  if (stops == 0) return {};
  return {Reading{
      {ContradictionKind::kEpochs, fmt::format("{}", fmt::join(names, ", ")),
       numbered ? "one epoch for all" : "no column epoch",
       fmt::format("that the times of its arrivals come in {} groups with pauses between, and in each of "
                   "them fit a vehicle that stands still",
                   stops),
       0.0,
       "add a column epoch that numbers the stops: rows with the same epoch share one pose of the vehicle"},
      {},
      [](std::size_t, MeasurementLog& run) { static_cast<void>(number_stops(run)); },
      true}};
}

}  // namespace octant::calib
