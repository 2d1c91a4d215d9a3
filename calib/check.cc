// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/check.h"

#include <algorithm>
#include <cmath>

#include "calib/calibrator.h"
#include "calib/log/subsampled_log.h"
#include "calib/readings/explain.h"
#include "calib/solution/variances.h"
#include "calib/statements/suspicions.h"

namespace octant::calib {
namespace {

/// Beacons that took part in the adjustment: their parameters are free, or they are control points.
std::vector<bool> usable_beacons(const Site& site, const Variances& variances) {
  std::vector<bool> usable;
  for (std::size_t b = 0; b < site.beacons.size(); ++b) {
    bool free = variances.has(parameters::beacon_delay(b));
    for (std::size_t i = 0; i < 3; ++i) free = free || variances.has(parameters::beacon_position(b, i));
    usable.push_back(free || site.beacons[b].is_control_point());
  }
  return usable;
}

/// Sigma beyond which a position counts as unknown, as in `calibrate`
constexpr double kUnobservableM = 1e4;

BeaconForecast beacon_forecast(const Site& site, std::size_t b, const Solution& s, const Variances& variances,
                               bool usable, double arrivals) {
  BeaconForecast f;
  f.name = site.beacons[b].name;
  f.arrivals = static_cast<std::size_t>(arrivals);
  if (b >= s.beacon_status.size()) return f;
  f.status = s.beacon_status[b];
  if (!usable || (arrivals == 0 && f.status == BeaconStatus::kUndetermined)) return f;
  f.position_m = s.state.beacon_p_map_m[b];
  const Eigen::Vector3d sigma = variances.beacon_sigma_m(b);
  if (sigma.maxCoeff() < kUnobservableM) f.sigma_m = sigma;
  if (variances.has(parameters::beacon_delay(b)))
    f.delay_sigma_s = variances.sigma(parameters::beacon_delay(b));
  return f;
}

void speed_forecast(Forecast& f) {
  const Solution& s = f.solution;
  if (s.beacon_status.empty()) return;
  f.speed_mps = speed_mps(f.subsampled.site.medium) + s.state.speed_offset(0);
  f.speed_sigma_mps = 0.0;
  const Variances variances(s);
  for (const ParameterId& id : {parameters::speed(), parameters::speed(1)})
    if (variances.has(id)) f.speed_sigma_mps = variances.sigma(id);
}

SubsampleOptions share_of(const SubsampleOptions& options, std::size_t rows, std::size_t all) {
  constexpr double kLeast = 0.05;
  const double share =
      std::max(kLeast, static_cast<double>(rows) / static_cast<double>(std::max<std::size_t>(all, 1)));
  SubsampleOptions o = options;
  o.instants = static_cast<std::size_t>(std::ceil(share * static_cast<double>(options.instants)));
  o.drive_arrivals = static_cast<std::size_t>(std::ceil(share * static_cast<double>(options.drive_arrivals)));
  return o;
}

}  // namespace

Forecast forecast(const Problem& whole, const SolveOptions& options,
                  const SubsampleOptions& subsample_options) {
  Forecast f;
  std::size_t rows = 0;
  for (const MeasurementLog& run : whole.runs) rows += run.arrivals.size() + run.bearings.size();
  std::vector<MeasurementLog> sample;
  for (const MeasurementLog& run : whole.runs) {
    const SubsampleOptions share =
        share_of(subsample_options, run.arrivals.size() + run.bearings.size(), rows);
    sample.push_back(subsample(run, whole.site, share));
  }
  auto subsampled = make_problem(whole.site, std::move(sample));
  // The whole log has observations and units. A subsample of it may still have lost all states by chance.
  f.subsampled = subsampled ? *subsampled : whole;
  f.subsampled.warnings = whole.warnings;
  const LogCounts all(whole), used(f.subsampled);
  f.arrivals = static_cast<std::size_t>(all.all_arrivals());
  f.arrivals_used = static_cast<std::size_t>(used.all_arrivals());
  f.states = all.states;
  f.states_used = used.states;

  ProgressMonitor monitor(options);
  SubsampledLog log(f.subsampled, all, options, monitor);
  f.solution = *solve_log(log, options, monitor);  // without reading there is no error
  if (f.solution.status == SolveStatus::kInterrupted) return f;
  explain(whole, f.subsampled, f.solution, options);
  const Variances variances(f.solution);
  const std::vector<bool> usable = usable_beacons(whole.site, variances);
  for (std::size_t b = 0; b < whole.site.beacons.size(); ++b)
    f.beacons.push_back(beacon_forecast(whole.site, b, f.solution, variances, usable[b], all.arrivals[b]));
  speed_forecast(f);
  return f;
}

std::vector<Finding> suspicions(const Forecast& f, std::vector<RunHealth>& runs) {
  if (f.solution.beacon_status.empty()) return {};  // there is no solution
  const double stride = f.is_subsampled() ? static_cast<double>(f.states) /
                                                static_cast<double>(std::max<std::size_t>(f.states_used, 1))
                                          : 1.0;
  return suspicions(Adjusted{f.subsampled.site, f.solution.state, f.solution.trajectories, stride}, runs);
}

}  // namespace octant::calib
