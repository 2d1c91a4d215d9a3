// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/stretches.h"

#include <algorithm>
#include <iterator>

#include "calib/problem/subsample.h"

namespace octant::calib {
namespace {

constexpr double kPitches = 10.0;  ///< number of segments of a drive
constexpr double kShortestStretch_s = 2.0;

/// Rows of a sorted list between two times.
template <class Row>
std::vector<Row> rows_between(const std::vector<Row>& rows, double from_s, double to_s) {
  std::vector<Row> some;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(some),
               [&](const Row& r) { return r.time_s >= from_s && r.time_s <= to_s; });
  return some;
}

/// @param from_s, to_s  within the drive
MeasurementLog stretch_of(const MeasurementLog& run, double from_s, double to_s) {
  MeasurementLog out = without_lists(run);
  out.poses = run.poses;
  out.arrivals = rows_between(run.arrivals, from_s, to_s);
  out.bearings = rows_between(run.bearings, from_s, to_s);
  out.odometry = rows_between(run.odometry, from_s, to_s);
  std::vector<VehicleId> anchored;
  for (OdometryStep& step : out.odometry) {  // the first row of each vehicle has no predecessor
    if (std::ranges::find(anchored, step.vehicle) != anchored.end()) continue;
    anchored.push_back(step.vehicle);
    step.set_pose({});
  }
  out.rows = out.arrivals.size();
  return out;
}

}  // namespace

std::vector<MeasurementLog> evenly_spread_stretches(const std::vector<MeasurementLog>& runs,
                                                    std::size_t arrivals) {
  std::size_t all = 0;
  for (const MeasurementLog& run : runs)
    if (!run.has_epochs) all += run.arrivals.size();
  if (all <= 2 * arrivals) return {};
  std::vector<MeasurementLog> out;
  for (const MeasurementLog& run : runs) {
    if (run.has_epochs || run.arrivals.empty()) {
      out.push_back(run);
      continue;
    }
    const double begin_s = run.arrivals.front().time_s, span_s = run.arrivals.back().time_s - begin_s;
    const double pitch_s = std::max(span_s / kPitches, 2 * kShortestStretch_s);
    const double length_s =
        std::max(kShortestStretch_s, pitch_s * static_cast<double>(arrivals) / static_cast<double>(all));
    for (double from_s = begin_s; from_s < begin_s + span_s; from_s += pitch_s)
      out.push_back(stretch_of(run, from_s, from_s + length_s));
  }
  return out;
}

}  // namespace octant::calib
