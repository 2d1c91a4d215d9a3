// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/steps/steps.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "calib/problem/unit_check.h"
#include "calib/revisit/revisited_site.h"
#include "models/changes/known_parameters.h"

namespace octant::app {
namespace {

constexpr double kOnePose_s =
    0.005;  ///< rows without an epoch that are farther apart belong to different poses
constexpr double kLongStop_s = 30.0;

/// Returns true if most poses of rows without epochs have arrivals of one beacon only.
bool one_beacon_at_a_time(const std::vector<Arrival>& arrivals) {
  std::size_t poses = 0, lonely = 0;
  for (std::size_t i = 0; i < arrivals.size();) {
    std::set<std::size_t> beacons;
    std::size_t end = i;
    do beacons.insert(arrivals[end++].beacon.index());
    while (end < arrivals.size() && arrivals[end].time_s - arrivals[end - 1].time_s <= kOnePose_s);
    i = end;
    ++poses;
    lonely += beacons.size() == 1 ? 1 : 0;
  }
  return 2 * lonely > poses;
}

}  // namespace

std::vector<std::string> doubts_about(const Deployment& deployment, const MeasurementLog& rows,
                                      bool pose_by_pose) {
  std::vector<std::string> doubts;
  if (rows.arrivals.empty()) return doubts;
  const KnownParameters known = known_parameters(deployment);
  const Site site = calib::revisited_site(deployment, known, known.covariance.diagonal());
  for (const calib::Finding& finding : calib::check_units(site, rows)) doubts.push_back(finding.text);
  if (!pose_by_pose) return doubts;
  const auto [first, last] = std::ranges::minmax_element(rows.arrivals, {}, &Arrival::epoch);
  if (first->epoch != last->epoch) return doubts;
  const double span_s = rows.arrivals.back().time_s - rows.arrivals.front().time_s;
  if (first->epoch != kNoEpoch) {
    if (span_s > kLongStop_s)
      doubts.push_back(fmt::format(
          "{} arrivals in {:.0f} s all have epoch {}: an epoch is one stop, give each a number of its own",
          rows.arrivals.size(), span_s, first->epoch));
  } else if (rows.odometry.empty() && one_beacon_at_a_time(rows.arrivals)) {
    doubts.push_back(
        "the rows have no epoch, and no two beacons are heard within 5 ms of each other, so each pose has "
        "one "
        "alone: number the vehicle's stops by epoch, or send its odometry; and is time_s in seconds?");
  }
  return doubts;
}

}  // namespace octant::app
