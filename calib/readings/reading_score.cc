// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/reading_score.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calib/adjust/adjust.h"
#include "calib/adjust/reject.h"
#include "calib/problem/subsample.h"
#include "calib/start/approach.h"

namespace octant::calib {
namespace {

/// Number of observations of the states other than arrivals.
double ties_of(const Trajectory& t) {
  return pose_dof(t.motion) * static_cast<double>(t.odometry.size() + t.poses.size()) +
         static_cast<double>(t.bearings.size());
}

/// Number of beacons whose position in the site file is no longer a prior.
std::size_t disregarded_places(const Site& site, const ParameterLayout& layout) {
  std::size_t count = 0;
  for (std::size_t b = 0; b < site.beacons.size(); ++b) {
    bool disregarded = false;
    for (std::size_t i = 0; i < 3; ++i)
      if (const int column = layout.beacon[b][i]; column >= 0 && site.beacons[b].sigma_m[i])
        disregarded = disregarded || !std::isfinite(layout.parameter(column).prior_sigma);
    count += disregarded;
  }
  return count;
}

double mean_delay_s(const SharedState& state) {
  const auto mean = [](const std::vector<double>& values) {
    return values.empty()
               ? 0.0
               : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  };
  return state.site_delay_s + mean(state.beacon_delay_s) + mean(state.receiver_delay_s);
}

/// Fills the fields that depend on the residuals of the arrivals.
void judge_arrivals(const Estimate& it, const std::vector<Trajectory>& trajectories, double cap, double n,
                    ReadingScore& score) {
  const SharedState state = it.state();
  double squares = 0.0, agreeing = 0.0, free = -static_cast<double>(it.layout.size());
  for (const Trajectory& t : trajectories) {
    free += ties_of(t);
    for (const Node& node : t.nodes) free -= node.placed ? t.block_size() : 0;
    for (const ArrivalObservation& a : t.arrivals) {
      if (!t.nodes[a.node].placed || a.rejection == Rejection::kBeaconUnusable) continue;
      const double residual = arrival_residual(t, a, state);
      score.sizes.push_back(std::abs(residual));
      if (a.rejection != Rejection::kUsed) continue;
      squares += residual * residual;
      agreeing += 1;
    }
  }
  const double others = std::max(0.0, it.last.cost - 0.5 * squares);  // priors, poses, odometry
  const double left_out = n - agreeing + static_cast<double>(score.disregarded);
  score.loss =
      (0.5 * squares / (score.noise * score.noise) + cap * left_out + others) / n + std::log(score.noise);
  score.agreeing = agreeing / n;
  score.redundancy = (agreeing + free) / n;
}

constexpr std::size_t kInstantsAtLeast = 10, kDriveArrivalsAtLeast = 200, kStretchesAtLeast = 8;

}  // namespace

std::vector<MeasurementLog> few_of(const std::vector<MeasurementLog>& runs, const Site& site,
                                   const LogShare& share) {
  SubsampleOptions subsample_options;
  const std::size_t count = std::max<std::size_t>(1, runs.size());
  subsample_options.instants = std::max(kInstantsAtLeast, share.instants / count);
  subsample_options.per_beacon = share.per_beacon;
  subsample_options.per_pair = 4;
  subsample_options.drive_arrivals = std::max(kDriveArrivalsAtLeast, share.drive_arrivals / count);
  subsample_options.fewest_stretches = std::max(kStretchesAtLeast, share.stretches / count);
  std::vector<MeasurementLog> sample;
  sample.reserve(runs.size());
  for (const MeasurementLog& run : runs) sample.push_back(subsample(run, site, subsample_options));
  return sample;
}

ReadingScore score_of(const Site& site, const std::vector<MeasurementLog>& runs, const SolveOptions& options,
                      bool search_again) {
  const double limit = options.rejection_sigmas, cap = 0.5 * limit * limit;
  ReadingScore score{.loss = cap};
  for (const MeasurementLog& run : runs) score.arrivals += static_cast<double>(run.arrivals.size());
  const double n = score.arrivals;
  const auto problem = make_problem(site, runs, options.threads);
  if (!problem || n == 0) return score;
  ProgressMonitor monitor(options);
  Approach found = approach(*problem, options, monitor, search_again);
  if (!found.ok) return score;
  Estimate& it = found.estimate;
  score.noise = std::max(1.0, agreeing_sigma(found.trajectories, it.state()));
  (void)reject_outliers(found.trajectories, it.state(), limit * score.noise, options.threads);
  it.last = adjust(*problem, it.layout, found.trajectories, it.x, monitor.adjust_options(0.0, 1e-6));
  score.disregarded = disregarded_places(problem->site, it.layout);
  score.beacon_p_map_m = it.state().beacon_p_map_m;
  score.receiver_p_vehicle_m = it.state().receiver_p_vehicle_m;
  score.delay_s = mean_delay_s(it.state());
  judge_arrivals(it, found.trajectories, cap, n, score);
  return score;
}

}  // namespace octant::calib
