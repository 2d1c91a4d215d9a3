// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/problem.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "calib/problem/flips.h"
#include "calib/problem/gates.h"
#include "calib/problem/log_health.h"
#include "calib/problem/ranges.h"
#include "calib/problem/site_units.h"
#include "models/trajectory/make_trajectory.h"

namespace octant::calib {
namespace {

/// Largest distance in the site file, including sigmas of its positions; 0 without any.
double site_extent_m(const Site& site, const MeasurementLog& run) {
  double extent = stated_extent_m(site, run.poses);
  if (!(extent > 0)) return 0.0;  // one point is no site
  for (const SiteBeacon& beacon : site.beacons)
    for (std::size_t i = 0; i < 3; ++i)
      if (beacon.position_m[i] && beacon.sigma_m[i]) extent = std::max(extent, *beacon.sigma_m[i]);
  return extent;
}

/// Detects milliseconds instead of seconds: the median distance exceeds the size of the site.
Result<void> check_unit(const Site& site, const MeasurementLog& run) {
  constexpr std::size_t kEnough = 100000;  // evenly spread ones of a long log tell the median as well
  std::vector<double> tof_s;
  for (std::size_t i = 0; i < run.arrivals.size(); i += run.arrivals.size() / kEnough + 1)
    tof_s.push_back(std::abs(run.arrivals[i].tof_s));
  if (tof_s.empty()) return {};
  const double median_s = median(std::move(tof_s));
  const double legs = site.timing.legs();
  const double distance_m =
      std::max(0.0, median_s - site.timing.turnaround_s) * speed_mps(site.medium) / legs;
  const double extent_m = site_extent_m(site, run);
  if (extent_m <= 0 || distance_m <= 20 * extent_m) return {};
  return fail(
      {.file = run.path + "/tof.csv",
       .line = run.arrivals.front().line,
       .found =
           fmt::format("a median time of flight of {:.6g} s, that is {:.6g} m, at a site {:.6g} m across",
                       median_s, distance_m, extent_m),
       .expected = "times of flight in seconds",
       .advice =
           "check whether the log is in milliseconds or microseconds, or whether medium.speed_mps is right"});
}

/// Checks the keys that may be left out only without arrivals.
Result<void> check_complete(const Site& site, const MeasurementLog& run) {
  if (run.arrivals.empty()) return {};
  const char* missing = !site.medium_given      ? "medium"
                        : !site.timing_given    ? "timing"
                        : !site.tof_sigma_given ? "noise.tof_sigma_s"
                                                : nullptr;
  if (missing == nullptr) return {};
  return fail({.file = site.path,
               .found = fmt::format("no {}, but {}/tof.csv has arrivals", missing, run.path),
               .expected = fmt::format("{} in the site file", missing),
               .advice = "state it: times of flight mean nothing without"});
}

/// Sigma of a measured heading above which it is not used.
constexpr double kMeaninglessRad = 1.0;
/// Fraction of the tolerance of a fix below which a lever arm may be fixed.
constexpr double kShareOfTolerance = 0.2;
constexpr double kUsualTolerance = 0.05;

/// Returns true if the positions of a vehicle were measured in a recording.
bool has_poses(const std::vector<Trajectory>& trajectories, VehicleId vehicle) {
  return std::ranges::any_of(trajectories,
                             [&](const Trajectory& t) { return t.vehicle == vehicle && !t.poses.empty(); });
}

/// Returns true if no observation determines the headings of a vehicle: a single position of its receivers,
/// at the origin where poses were measured, no bearings, no odometry, no measured headings.
bool is_headless(const Site& site, const std::vector<Trajectory>& trajectories, VehicleId vehicle) {
  if (site.motion != Motion::kPlanar || has_heading(site, vehicle, has_poses(trajectories, vehicle)))
    return false;
  return std::ranges::none_of(trajectories, [&](const Trajectory& t) {
    return t.vehicle == vehicle && (!t.bearings.empty() || !t.odometry.empty() || t.motion_prior ||
                                    std::ranges::any_of(t.poses, [](const PoseObservation& p) {
                                      return p.heading_sigma_rad < kMeaninglessRad;
                                    }));
  });
}

/// Fixes lever arms that the data do not determine. Without headings, each stop can rotate freely, and a
/// common rotation has no effect. A free lever arm would grow until it absorbs the errors of each stop, and
/// the adjustment would not converge. A receiver that is known well enough is therefore fixed at its given
/// position, and measured positions get its sigma in addition. If no position was measured either, the
/// vehicle's origin is placed at its receiver, because a search with a lever arm of decimetres would end in
/// circles.
/// @return Problem::held_lever_sigma_m
std::vector<double> hold_levers(Site& site, const std::vector<Trajectory>& trajectories) {
  std::vector<double> held_m(site.vehicles.size(), 0.0);
  for (std::size_t v = 0; v < site.vehicles.size(); ++v) {
    if (!is_headless(site, trajectories, VehicleId(v))) continue;
    const bool posed = has_poses(trajectories, VehicleId(v));
    double sigma_m = 0.0;
    for (SiteReceiver& r : site.receivers) {
      if (r.vehicle.index() != v) continue;
      sigma_m = std::max(sigma_m, r.sigma_m.head<2>().maxCoeff());
    }
    if (sigma_m > kShareOfTolerance * site.tolerance.fix_m.value_or(kUsualTolerance)) continue;
    for (SiteReceiver& r : site.receivers) {
      if (r.vehicle.index() != v) continue;
      r.sigma_m.head<2>().setZero();
      if (posed) continue;
      r.taken_off_m += r.position_m.head<2>();
      r.position_m.head<2>().setZero();
    }
    held_m[v] = sigma_m;
  }
  return held_m;
}

}  // namespace

Problem without_recordings(const Problem& problem) {
  Problem out;
  out.site = problem.site;
  out.beacon_ranges = problem.beacon_ranges;
  out.runs.resize(problem.runs.size());
  out.typical_range_m = problem.typical_range_m;
  return out;
}

TrajectoryModel trajectory_model(const Site& site) {
  TrajectoryModel model{site.motion, site.medium, site.timing, site.noise, {}, {}};
  if (site.attenuation) model.attenuation = site.attenuation->mean();
  for (const SiteVehicle& vehicle : site.vehicles) model.motion_priors.push_back(vehicle.motion);
  return model;
}

void widen_poses(const Problem& problem, Trajectory& t) {
  const double sigma_m = problem.held_lever_sigma_m.at(t.vehicle.index());
  for (PoseObservation& p : t.poses) p.position_sigma_m = std::hypot(p.position_sigma_m, sigma_m);
}

std::string stateless_in_words(const MeasurementLog& run, int line, std::size_t count) {
  return fmt::format(
      "{}/tof.csv:{}: {} arrivals have no vehicle state at their time (beyond odometry or in a gap of "
      "{}) and are left out",
      run.path, line, count, pose_file(run));
}

namespace {

/// Error for a problem without any state. If arrivals and poses do not overlap in time, it names both spans.
Error without_observations(const Site& site, const std::vector<MeasurementLog>& runs) {
  Error error{.file = runs.empty() ? site.path : runs.front().path + "/tof.csv",
              .found = "no arrival or bearing to calibrate with",
              .expected = "rows of times of flight or bearings with a vehicle state at their time",
              .advice =
                  "record a run while the beacons fire, or check the measured poses and odometry.csv against "
                  "the times in tof.csv"};
  for (const MeasurementLog& run : runs) {
    if (run.arrivals.empty() || (run.poses.empty() && run.odometry.empty())) continue;
    const double pose_first_s = run.poses.empty() ? run.odometry.front().time_s : run.poses.front().time_s,
                 pose_last_s = run.poses.empty() ? run.odometry.back().time_s : run.poses.back().time_s,
                 first_s = run.arrivals.front().time_s, last_s = run.arrivals.back().time_s;
    error.found += fmt::format(
        "; time_s of tof.csv runs from {:.6g} to {:.6g}, that of the vehicle's motion "
        "from {:.6g} to {:.6g} s",
        first_s, last_s, pose_first_s, pose_last_s);
    const double ratio = (last_s - first_s) / std::max(1e-9, pose_last_s - pose_first_s);
    for (const auto& [name, factor] :
         {std::pair{"milliseconds", 1e3}, std::pair{"microseconds", 1e6}, std::pair{"nanoseconds", 1e9}})
      if (std::abs(std::log(ratio / factor)) < std::log(3.0))
        error.advice = fmt::format("time_s of tof.csv looks like {}: divide it by {:g}", name, factor);
    break;
  }
  return error;
}

/// An exact distance is a constraint: it is weighted as if it were known to a tenth of a millimetre, which no
/// survey of a site exceeds and which keeps the normal equations well conditioned.
constexpr double kExactDistance_m = 1e-4;

}  // namespace

Result<Problem> make_problem(Site site, std::vector<MeasurementLog> runs, int threads) {
  Problem problem;
  for (ControlDistance& d : site.distances) d.sigma_m = std::max(d.sigma_m, kExactDistance_m);
  std::size_t observations = 0;
  const TrajectoryModel model = trajectory_model(site);
  if (auto ok = check_site_units(site, runs); !ok) return fail(ok.error());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (auto ok = check_complete(site, runs[i]); !ok) return fail(ok.error());
    if (auto ok = check_unit(site, runs[i]); !ok) return fail(ok.error());
    for (std::size_t v = 0; v < site.vehicles.size(); ++v) {
      Trajectory t = make_trajectory(runs[i], i, VehicleId(v), model);
      if (t.arrivals.empty() && t.bearings.empty() && t.stateless_arrivals.empty()) continue;
      observations += t.arrivals.size() + t.bearings.size();
      if (!t.stateless_arrivals.empty())
        problem.warnings.push_back(stateless_in_words(
            runs[i], runs[i].arrivals[t.stateless_arrivals.front()].line, t.stateless_arrivals.size()));
      problem.trajectories.push_back(std::move(t));
    }
  }
  if (observations == 0) return fail(without_observations(site, runs));
  problem.held_lever_sigma_m = hold_levers(site, problem.trajectories);
  for (Trajectory& t : problem.trajectories) widen_poses(problem, t);
  apply_gates(site, problem.trajectories, threads);
  problem.typical_range_m = typical_range_m(site, problem.trajectories);
  problem.site = std::move(site);
  problem.runs = std::move(runs);
  return problem;
}

}  // namespace octant::calib
