// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/log/subsampled_log.h"

#include <cmath>
#include <numeric>
#include <utility>

#include "calib/adjust/reject.h"
#include "calib/problem/ranges.h"

namespace octant::calib {

LogCounts::LogCounts(const Problem& problem) {
  arrivals.assign(problem.site.beacons.size(), 0.0);
  bearings.assign(problem.site.beacons.size(), 0.0);
  for (const Trajectory& t : problem.trajectories) {
    for (const ArrivalObservation& a : t.arrivals) arrivals[a.beacon.index()] += 1;
    for (const BearingObservation& b : t.bearings)
      if (b.reflector.valid()) bearings[b.reflector.index()] += 1;
    poses += static_cast<double>(t.poses.size());
    states += t.nodes.size();
  }
}

double LogCounts::all_arrivals() const { return std::accumulate(arrivals.begin(), arrivals.end(), 0.0); }

namespace {

double sigma_factor(double complete, double subsampled) {
  return complete > subsampled && subsampled > 0 ? std::sqrt(subsampled / complete) : 1.0;
}

/// Odometry of the sampled segments represents that of the omitted ones; the accuracy of summed odometry
/// between them follows from its length.
void weigh_odometry(Trajectory& t, double factor) {
  const auto duration_s = [&t](const OdometryObservation& o) {
    return t.nodes[o.node + 1].time_s - t.nodes[o.node].time_s;
  };
  std::vector<double> durations;
  for (const OdometryObservation& o : t.odometry) durations.push_back(duration_s(o));
  const double usual_s = median(std::move(durations));
  for (OdometryObservation& o : t.odometry) {
    if (duration_s(o) > 1.5 * usual_s) continue;
    o.distance_sigma_m *= factor;
    o.heading_sigma_rad *= factor;
  }
}

/// Each observation is as accurate as all those together that it represents. Odometry between stops is
/// complete and unchanged.
void weight_as_complete(std::vector<Trajectory>& trajectories, const LogCounts& complete,
                        const LogCounts& subsampled) {
  const double drive = sigma_factor(complete.all_arrivals(), subsampled.all_arrivals());
  for (Trajectory& t : trajectories) {
    if (t.moving) weigh_odometry(t, drive);
    for (ArrivalObservation& a : t.arrivals) {
      const double f =
          sigma_factor(complete.arrivals[a.beacon.index()], subsampled.arrivals[a.beacon.index()]);
      a.sigma_s *= f;
      a.log_amplitude_sigma *= f;
    }
    for (BearingObservation& b : t.bearings)
      if (b.reflector.valid())
        b.sigma_rad *=
            sigma_factor(complete.bearings[b.reflector.index()], subsampled.bearings[b.reflector.index()]);
  }
  rescale_poses(trajectories, sigma_factor(complete.poses, subsampled.poses));
}

}  // namespace

Result<Findings> SubsampledLog::findings(const Estimate& estimate) {
  const LogCounts subsampled(problem());
  auto all = HeldLog::findings(estimate);
  if (!all || subsampled.all_arrivals() >= whole_.all_arrivals()) return all;
  all->as_complete = all->trajectories;
  weight_as_complete(all->as_complete, whole_, subsampled);
  return all;
}

}  // namespace octant::calib
