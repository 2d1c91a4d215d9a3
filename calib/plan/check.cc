// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/plan/check.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "calib/errors/variances.h"
#include "calib/problem/ranges.h"
#include "calib/start/label_check.h"
#include "calib/verdict/observability.h"

namespace octant::calib {
namespace {

struct Counts {
  std::vector<double> arrivals, bearings;  ///< by beacon
  double poses = 0.0;
  std::size_t states = 0;
};

Counts count(const std::vector<Trajectory>& trajectories, std::size_t beacons) {
  Counts c;
  c.arrivals.assign(beacons, 0.0);
  c.bearings.assign(beacons, 0.0);
  for (const Trajectory& t : trajectories) {
    for (const ArrivalObservation& a : t.arrivals) c.arrivals[a.beacon.index()] += 1;
    for (const BearingObservation& b : t.bearings)
      if (b.reflector.valid()) c.bearings[b.reflector.index()] += 1;
    c.poses += static_cast<double>(t.poses.size());
    c.states += t.nodes.size();
  }
  return c;
}

double sigma_factor(double whole, double few) {
  return whole > few && few > 0 ? std::sqrt(few / whole) : 1.0;
}

/// Odometry of a drive's stretches stands for that of stretches left out; what was summed up between them is
/// told by its length.
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

/// Each observation as accurate as all those together that it stands for. Odometry between stops is complete
/// as it is.
void weigh_as_whole(std::vector<Trajectory>& trajectories, const Counts& whole, const Counts& few) {
  const double pose = sigma_factor(whole.poses, few.poses);
  const auto sum = [](const std::vector<double>& n) { return std::accumulate(n.begin(), n.end(), 0.0); };
  const double drive = sigma_factor(sum(whole.arrivals), sum(few.arrivals));
  for (Trajectory& t : trajectories) {
    if (t.moving) weigh_odometry(t, drive);
    for (ArrivalObservation& a : t.arrivals) {
      const double f = sigma_factor(whole.arrivals[a.beacon.index()], few.arrivals[a.beacon.index()]);
      a.sigma_s *= f;
      a.log_amplitude_sigma *= f;
    }
    for (BearingObservation& b : t.bearings)
      if (b.reflector.valid())
        b.sigma_rad *= sigma_factor(whole.bearings[b.reflector.index()], few.bearings[b.reflector.index()]);
    for (PoseObservation& p : t.poses) {
      p.position_sigma_m *= pose;
      p.heading_sigma_rad *= pose;
      p.attitude_sigma_rad *= pose;
    }
  }
}

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

/// The verdict of judge() once more, from the weights of all the data.
void judge_as_whole(const Problem& thinned, const Counts& whole, const Counts& few,
                    const SolveOptions& options, Solution& solution) {
  const std::vector<bool> usable = usable_beacons(thinned.site, Variances(solution));
  std::vector<bool> held(usable.size()), mirrored(usable.size(), false);
  for (std::size_t b = 0; b < usable.size(); ++b) {
    held[b] = !usable[b];
    const bool doubtful = usable[b] && solution.beacon_status[b] == BeaconStatus::kUndetermined;
    mirrored[b] = doubtful && b < solution.beacon_mirrored.size() && solution.beacon_mirrored[b];
  }
  ParameterLayout layout = make_layout(thinned, solution.state, held);
  layout.dense_limit = options.dense_limit;
  const Eigen::VectorXd x = layout.vector_of(solution.state);
  (void)check_labels(thinned, layout, x);  // mends the priors as solve() did; it has warned already

  Solution whole_solution = solution;
  whole_solution.status =
      solution.statistics.converged ? SolveStatus::kConverged : SolveStatus::kNotConverged;
  whole_solution.message = solution.statistics.converged ? "converged" : solution.message;
  whole_solution.covariance = {};
  whole_solution.marginals = {};
  whole_solution.beacon_status.clear();
  whole_solution.weak.clear();
  whole_solution.undetermined.clear();
  std::erase_if(whole_solution.warnings, [](const std::string& w) {
    return w.find(" is undetermined: ") != std::string::npos ||
           w.find(" beacons are undetermined: ") != std::string::npos;
  });
  std::vector<Trajectory> weighed = solution.trajectories;
  weigh_as_whole(weighed, whole, few);
  static_cast<void>(judge(thinned, layout, x, usable, mirrored, options.strict, weighed, whole_solution));
  whole_solution.trajectories = std::move(solution.trajectories);
  solution = std::move(whole_solution);
}

constexpr double kUnseenM = 1e4;  ///< as calibrate's words have it: beyond it nothing is known

BeaconForecast beacon_forecast(const Site& site, std::size_t b, const Solution& s, const Variances& variances,
                               bool usable, double arrivals) {
  BeaconForecast f;
  f.name = site.beacons[b].name;
  f.arrivals = static_cast<std::size_t>(arrivals);
  if (b >= s.beacon_status.size()) return f;
  f.status = s.beacon_status[b];
  if (!usable || (arrivals == 0 && f.status == BeaconStatus::kUndetermined)) return f;
  f.position_m = s.state.beacon_p_map_m[b];
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    sigma[static_cast<Eigen::Index>(i)] = variances.sigma(parameters::beacon_position(b, i));
  if (sigma.maxCoeff() < kUnseenM) f.sigma_m = sigma;
  if (variances.has(parameters::beacon_delay(b)))
    f.delay_sigma_s = variances.sigma(parameters::beacon_delay(b));
  return f;
}

void speed_forecast(Forecast& f) {
  const Solution& s = f.solution;
  if (s.beacon_status.empty()) return;
  f.speed_mps = speed_mps(f.thinned.site.medium) + s.state.speed_offset(0);
  f.speed_sigma_mps = 0.0;
  const Variances variances(s);
  for (const ParameterId& id : {parameters::speed(), parameters::speed(1)})
    if (variances.has(id)) f.speed_sigma_mps = variances.sigma(id);
}

ThinOptions share_of(const ThinOptions& options, std::size_t rows, std::size_t all) {
  constexpr double kLeast = 0.05;
  const double share =
      std::max(kLeast, static_cast<double>(rows) / static_cast<double>(std::max<std::size_t>(all, 1)));
  ThinOptions o = options;
  o.instants = static_cast<std::size_t>(std::ceil(share * static_cast<double>(options.instants)));
  o.drive_arrivals = static_cast<std::size_t>(std::ceil(share * static_cast<double>(options.drive_arrivals)));
  return o;
}

}  // namespace

Forecast forecast(const Problem& whole, const SolveOptions& options, const ThinOptions& thin_options) {
  Forecast f;
  std::size_t rows = 0;
  for (const MeasurementLog& run : whole.runs) rows += run.arrivals.size() + run.bearings.size();
  std::vector<MeasurementLog> few;
  for (const MeasurementLog& run : whole.runs) {
    const ThinOptions share = share_of(thin_options, run.arrivals.size() + run.bearings.size(), rows);
    few.push_back(thin(run, whole.site, share));
  }
  auto thinned = make_problem(whole.site, std::move(few));
  // The whole had observations and kept its unit; what is left of it may still have lost its states by bad
  // luck.
  f.thinned = thinned ? *thinned : whole;
  f.thinned.warnings = whole.warnings;
  const Counts all = count(whole.trajectories, whole.site.beacons.size()),
               used = count(f.thinned.trajectories, whole.site.beacons.size());
  for (const double n : all.arrivals) f.arrivals += static_cast<std::size_t>(n);
  for (const double n : used.arrivals) f.arrivals_used += static_cast<std::size_t>(n);
  f.states = all.states;
  f.states_used = used.states;

  f.solution = solve(f.thinned, options);
  if (f.solution.status == SolveStatus::kInterrupted) return f;
  const bool judged = !f.solution.beacon_status.empty();
  if (judged && f.is_thinned()) judge_as_whole(f.thinned, all, used, options, f.solution);
  const Variances variances(f.solution);
  const std::vector<bool> usable = usable_beacons(whole.site, variances);
  for (std::size_t b = 0; b < whole.site.beacons.size(); ++b)
    f.beacons.push_back(beacon_forecast(whole.site, b, f.solution, variances, usable[b], all.arrivals[b]));
  speed_forecast(f);
  return f;
}

}  // namespace octant::calib
