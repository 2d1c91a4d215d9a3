// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/methods.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "models/localizers/binaural/binaural.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/common/rows_by_pose.h"
#include "models/localizers/drive/tracker.h"
#include "models/localizers/head_tail/head_tail.h"
#include "models/localizers/kleeman/kleeman.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/rail/one_beacon.h"
#include "models/localizers/rail/rail.h"
#include "models/localizers/reflectors/reflectors.h"
#include "models/localizers/space/space_track.h"
#include "models/localizers/speed/one_speed.h"

namespace octant {
namespace {

tl::unexpected<Error> missing(const char* found, const char* expected) {
  return fail({.code = Errc::kBadInput,
               .found = found,
               .expected = expected,
               .advice = "choose another --method, or auto"});
}

bool has_motion_prior(const Deployment& deployment) {
  return std::ranges::any_of(deployment.vehicles, [](const SiteVehicle& v) { return v.motion.has_value(); });
}

bool on_rails(const Deployment& deployment) {
  return !deployment.vehicles.empty() &&
         std::ranges::all_of(deployment.vehicles, [](const SiteVehicle& v) { return v.rail.has_value(); });
}

/// Stops can be tied together by the odometry between them.
bool can_chain(const Deployment& deployment) {
  return deployment.motion == Motion::kPlanar && deployment.timing.clock == Clock::kSynchronised;
}

/// Returns true for a drive in the plane whose states nothing connects, and which has too few arrivals at a
/// time for single fixes: its vehicles are assumed to move as usual (MotionPrior).
bool is_drive_with_assumed_motion(const Deployment& deployment, const MeasurementLog& run) {
  constexpr std::size_t kFixArrivals = 3;  // as many as a pose in the plane has unknowns
  if (!can_chain(deployment) || has_motion_prior(deployment) || on_rails(deployment) || run.has_epochs ||
      !run.odometry.empty() || !run.poses.empty() || !run.bearings.empty())
    return false;
  std::size_t poses = 0, rich = 0;
  for (std::size_t v = 0; v < deployment.vehicles.size(); ++v) {
    const RowsByPose<Arrival> rows(run.arrivals, VehicleId(v), false);
    poses += rows.count();
    for (std::size_t i = 0; i < rows.count(); ++i) rich += rows.pose(i).size() >= kFixArrivals;
  }
  return 2 * rich < poses;
}

Deployment with_usual_motion(Deployment deployment) {
  for (SiteVehicle& vehicle : deployment.vehicles) vehicle.motion.emplace();
  return deployment;
}

bool is_drive(const Deployment& deployment, const MeasurementLog& run) {
  return is_drive_in_space(deployment, run) || is_drive_with_assumed_motion(deployment, run) ||
         (!run.has_epochs && (!run.odometry.empty() || (has_motion_prior(deployment) && run.poses.empty())));
}

/// Arrivals and bearings of the same pose together: of the same epoch, or of about the same time.
template <class Visit>
void for_each_pose(const MeasurementLog& run, VehicleId vehicle, Visit&& visit) {
  const RowsByPose<Arrival> arrivals(run.arrivals, vehicle, run.has_epochs);
  const RowsByPose<Bearing> bearings(run.bearings, vehicle, run.has_epochs);
  std::size_t b = 0;
  const auto comes_before = [&](const Bearing& bearing, const Arrival& arrival) {
    return run.has_epochs ? bearing.time_s < arrival.time_s && bearing.epoch != arrival.epoch
                          : bearing.time_s < arrival.time_s - kSamePing_s;
  };
  const auto together = [&](const Bearing& bearing, const Arrival& arrival) {
    return run.has_epochs ? bearing.epoch == arrival.epoch
                          : std::abs(bearing.time_s - arrival.time_s) <= kSamePing_s;
  };
  for (std::size_t a = 0; a < arrivals.count(); ++a) {
    const auto pose = arrivals.pose(a);
    while (b < bearings.count() && comes_before(bearings.pose(b).front(), pose.front()))
      visit(Observations{{}, bearings.pose(b++)});
    if (b < bearings.count() && together(bearings.pose(b).front(), pose.front())) {
      visit(Observations{pose, bearings.pose(b++)});
    } else {
      visit(Observations{pose, {}});
    }
  }
  while (b < bearings.count()) visit(Observations{{}, bearings.pose(b++)});
}

std::vector<Fix> locate_by_poses(Localizer& localizer, const Deployment& deployment,
                                 const MeasurementLog& run, bool by_bearings) {
  std::vector<Fix> fixes;
  for (std::size_t v = 0; v < deployment.vehicles.size(); ++v)
    for_each_pose(run, VehicleId(v), [&](const Observations& observations) {
      if (by_bearings ? observations.bearings.empty() : observations.arrivals.empty()) return;
      Fix fix = localizer.locate(observations);
      fix.vehicle = VehicleId(v);
      fix.epoch = by_bearings ? observations.bearings.front().epoch : observations.arrivals.front().epoch;
      fixes.push_back(std::move(fix));
    });
  std::ranges::stable_sort(fixes, {}, &Fix::time_s);
  return fixes;
}

}  // namespace

std::unique_ptr<Localizer> make_localizer(Method method, const Deployment& deployment,
                                          const MethodInput& input) {
  switch (method) {
    case Method::kKleeman:
      return std::make_unique<Kleeman>(deployment, KleemanOptions{.heading = input.kleeman_heading});
    case Method::kHeadTail: return std::make_unique<HeadTail>(deployment);
    case Method::kOneBeacon: return std::make_unique<OneBeacon>(deployment);
    case Method::kRail: return std::make_unique<RailLocalizer>(deployment);
    case Method::kReflectors: return std::make_unique<Reflectors>(deployment);
    case Method::kLeastSquares: return std::make_unique<LeastSquaresLocalizer>(deployment);
    case Method::kBinaural: return std::make_unique<Binaural>(deployment);
    default: return nullptr;
  }
}

const std::vector<std::pair<std::string_view, Method>>& method_names() {
  static const std::vector<std::pair<std::string_view, Method>> names = {
      {"auto", Method::kAuto},
      {"kleeman", Method::kKleeman},
      {"head_tail", Method::kHeadTail},
      {"one_beacon", Method::kOneBeacon},
      {"rail", Method::kRail},
      {"reflectors", Method::kReflectors},
      {"line_map", Method::kLineMap},
      {"binaural", Method::kBinaural},
      {"least_squares", Method::kLeastSquares},
      {"tracker", Method::kTracker}};
  return names;
}

const char* to_string(Method method) { return method_names()[static_cast<std::size_t>(method)].first.data(); }

const char* why_no_level(Method method) {
  switch (method) {
    case Method::kKleeman:
      return "it averages triples of beacons, which is no adjustment to leave one out of";
    case Method::kHeadTail:
      return "it averages triangles, end by end, which is no adjustment to leave one out of";
    case Method::kBinaural: return "without one of the other robot's transmitters two ranges are left";
    case Method::kLineMap: return "it matches scans to walls, and hears no beacons";
    default: return "";
  }
}

Result<void> method_fits(Method method, const Deployment& deployment, const MeasurementLog& run,
                         const MethodInput& input) {
  const bool by_arrivals = method == Method::kKleeman || method == Method::kHeadTail ||
                           method == Method::kOneBeacon || method == Method::kRail ||
                           method == Method::kBinaural;
  if (by_arrivals && run.arrivals.empty()) return missing("no times of flight", "a run with tof.csv");
  switch (method) {
    case Method::kKleeman: return kleeman_fits(deployment);
    case Method::kHeadTail: return head_tail_fits(deployment);
    case Method::kOneBeacon: return one_beacon_fits(deployment);
    case Method::kRail: return rail_fits(deployment);
    case Method::kBinaural: return binaural_fits(deployment);
    case Method::kReflectors:
      if (run.bearings.empty()) return missing("no bearings", "a run with bearings.csv");
      return reflectors_fits(deployment);
    case Method::kLineMap:
      if (!input.line_map) return missing("no line map", "--map with a run of scans and measured poses");
      return line_map_fits(*input.line_map, run);
    case Method::kTracker:
      if (run.has_epochs && may_track_in_space(deployment, run)) return {};
      if (run.has_epochs && run.odometry.empty())
        return missing("stops without odometry", "odometry.csv between them, or a drive: no epoch column");
      if (run.has_epochs && !can_chain(deployment))
        return missing("stops of a vehicle in space or with a clock of its own",
                       "planar motion and synchronised clocks");
      if (!run.has_epochs && !is_drive(deployment, run))
        return missing("a drive without odometry", "odometry.csv, or motion of the vehicle in the site file");
      return {};
    case Method::kAuto:
    case Method::kLeastSquares: break;
  }
  if (method == Method::kLeastSquares && run.arrivals.empty() && run.bearings.empty())
    return missing("neither arrivals nor bearings", "a run with tof.csv");
  return {};
}

MethodChoice choose_method(const Deployment& deployment, const MeasurementLog& run,
                           const MethodInput& input) {
  const bool unlabelled =
      std::ranges::any_of(run.bearings, [](const Bearing& b) { return !b.reflector.valid(); });
  if (run.arrivals.empty() && unlabelled && method_fits(Method::kReflectors, deployment, run, input))
    return {Method::kReflectors, "unlabelled bearings"};
  if (run.arrivals.empty() && run.bearings.empty() && !run.scans.empty())
    return {Method::kLineMap, "scans alone"};
  if (!run.arrivals.empty() && on_rails(deployment) && rail_fits(deployment))
    return {Method::kRail, "the vehicle runs on a rail"};
  if (is_drive_in_space(deployment, run)) return {Method::kTracker, "a drive in space"};
  if (is_drive(deployment, run))
    return {Method::kTracker, is_drive_with_assumed_motion(deployment, run)
                                  ? "a drive, whose vehicle is assumed to move as usual (vehicles[].motion)"
                              : run.odometry.empty() ? "a drive with a motion prior"
                                                     : "a drive with odometry"};
  if (run.has_epochs && !run.arrivals.empty() && !run.odometry.empty() && can_chain(deployment))
    return {Method::kTracker, "stops with odometry between them"};
  return {Method::kLeastSquares, "all arrivals of each pose"};
}

namespace {

std::vector<Fix> locate_at_one_speed(Method method, const Deployment& deployment, const MeasurementLog& run,
                                     const MethodInput& input) {
  if (method == Method::kTracker) {
    // Protection levels would depend on the assumption.
    if (is_drive_with_assumed_motion(deployment, run)) return track(run, with_usual_motion(deployment));
    return track(run, deployment, {.protect = true});
  }
  if (method == Method::kLeastSquares) return LeastSquaresLocalizer(deployment).locate(run);
  if (method == Method::kLineMap) return LineMapLocalizer(*input.line_map).locate(run);
  return locate_by_poses(*make_localizer(method, deployment, input), deployment, run,
                         method == Method::kReflectors);
}

}  // namespace

Result<std::vector<Fix>> locate_run(Method method, const Deployment& deployment,
                                    const MeasurementLog& all_rows, const MethodInput& input) {
  // Each round brings the fixes nearer by a factor of about a hundred (ray_speeds.h).
  constexpr int kRayRounds = 3;
  MeasurementLog room;
  const MeasurementLog& run = known_rows(all_rows, deployment, room);
  if (method == Method::kAuto) method = choose_method(deployment, run, input).method;
  if (auto fits = method_fits(method, deployment, run, input); !fits) return fail(fits.error());
  if (deployment.medium.profile == nullptr || run.arrivals.empty())
    return locate_at_one_speed(method, deployment, run, input);
  MeasurementLog changed = run;
  std::vector<Fix> fixes;
  for (int round = 0; round < kRayRounds; ++round) {
    changed.arrivals = at_one_speed(run.arrivals, fixes, deployment);
    fixes = locate_at_one_speed(method, deployment, changed, input);
  }
  return fixes;
}

}  // namespace octant
