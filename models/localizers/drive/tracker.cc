// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/tracker.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "models/localizers/common/arrival_rejections.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/common/correlated_arrivals.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/drive_filter.h"
#include "models/localizers/drive/drive_tracker.h"
#include "models/localizers/drive/drive_uncertainty.h"
#include "models/localizers/drive/motion_velocity.h"
#include "models/localizers/drive/odometry_track.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/least_squares/node_adjustment.h"
#include "models/localizers/space/space_track.h"
#include "models/localizers/start/drive_start.h"
#include "models/localizers/start/motion_start.h"
#include "models/localizers/start/rigid_path.h"
#include "models/localizers/start/rough_path.h"
#include "models/localizers/start/stretch_states.h"
#include "models/physics/plane.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/make_trajectory.h"
#include "models/trajectory/solve_states.h"
#include "models/trajectory/stretches.h"

namespace octant {
namespace {

constexpr int kSegmentOutlierRounds = 5;
/// Relative decrease of the cost that ends the iteration, before and after arrivals are marked.
constexpr double kNearlyConverged = 1e-5, kConverged = 1e-10;

/// Moves a filter along an odometry step from one of its instants to another, in either direction.
template <class Filter>
void move_along(const OdometryObservation& step, double to, double& at, Filter& filter) {
  if (to == at) return;
  const Pose part =
      interpolate(Pose{}, step.T_before_after, at).inverse() * interpolate(Pose{}, step.T_before_after, to);
  filter.predict(part, step, std::abs(to - at));
  at = to;
}

/// Filters forward from a node to the end of the segment, or until it is lost; returns the node reached.
template <class Filter>
std::size_t run_forward(Trajectory& t, const Segment& segment, Filter& filter, std::size_t node) {
  std::size_t next = first_of_node(t.arrivals, node, segment.first_arrival, segment.last_arrival);
  for (; node + 1 < segment.last_node; ++node) {
    const OdometryObservation& step = t.odometry[segment.first_odometry + node - segment.first_node];
    double at = 0.0;
    for (; next < segment.last_arrival && t.arrivals[next].node == node; ++next) {
      move_along(step, t.arrivals[next].alpha, at, filter);
      t.arrivals[next].rejection = filter.update(t, t.arrivals[next]);
    }
    move_along(step, 1.0, at, filter);
    t.nodes[node + 1].T_map_vehicle = filter.pose();
    t.nodes[node + 1].placed = true;
    if (filter.is_lost()) return node + 1;
  }
  return node;
}

/// Filters backward from a node to the beginning of the segment.
template <class Filter>
void run_backward(Trajectory& t, const Segment& segment, Filter& filter, std::size_t node) {
  std::size_t next = first_of_node(t.arrivals, node, segment.first_arrival, segment.last_arrival);
  for (; node > segment.first_node; --node) {
    const OdometryObservation& step = t.odometry[segment.first_odometry + node - 1 - segment.first_node];
    double at = 1.0;
    for (; next > segment.first_arrival && t.arrivals[next - 1].node == node - 1; --next) {
      move_along(step, t.arrivals[next - 1].alpha, at, filter);
      static_cast<void>(filter.update(t, t.arrivals[next - 1]));
    }
    move_along(step, 0.0, at, filter);
    t.nodes[node - 1].T_map_vehicle = filter.pose();
    t.nodes[node - 1].placed = true;
  }
}

/// Places one part of the drive and filters from there in both directions; where the filter is lost, the next
/// part is placed.
template <int kDof>
bool place_by_filter(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                     const TrackerOptions& options) {
  DriveFilterOf<kDof> filter(model, options.rejection_sigmas,
                             independent_uncertainty_m(t, segment, model, options.range_uncertainty_m));
  std::size_t from = segment.first_node;
  bool placed = false;
  while (from + 2 <= segment.last_node) {
    const DriveStart start = find_start(t, segment, model, options, from);
    if (!start.found) break;
    const Segment stretch = stretch_of(t, segment, start.first_node, start.last_node);
    if (!placed) {
      filter.start(t.nodes[start.first_node].T_map_vehicle,
                   start_covariance(t, stretch, model, options.range_uncertainty_m, start.first_node));
      run_backward(t, segment, filter, start.first_node);
      placed = true;
    }
    filter.start(t.nodes[start.last_node - 1].T_map_vehicle,
                 start_covariance(t, stretch, model, options.range_uncertainty_m, start.last_node - 1));
    from = run_forward(t, segment, filter, start.last_node - 1);
    if (from + 1 >= segment.last_node) return true;
  }
  // Nodes without a pose follow odometry, so that the adjustment has all states.
  if (placed) static_cast<void>(follow_odometry(t, segment, from, true));
  return placed;
}

/// Returns true for spatial drives among roughly known beacons.
bool goes_by_pieces(const Trajectory& t, const TrackerOptions& options) {
  return t.motion == Motion::kSpatial && options.range_uncertainty_m > 0 && !t.motion_prior;
}

/// Initial states of a whole segment.
bool place_segment(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                   const TrackerOptions& options) {
  if (t.motion_prior) return place_by_motion(t, segment, model, options);
  if (t.motion == Motion::kPlanar) return place_by_filter<3>(t, segment, model, options);
  if (goes_by_pieces(t, options)) return place_roughly(t, segment, model, options);
  return place_by_filter<6>(t, segment, model, options);
}

/// Robust adjustment of a placed segment from coarse to fine, then with the squared loss and without
/// outliers. Arrivals are judged by their own sigmas and keep the sigmas of their weights.
bool smooth_segment(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                    const TrackerOptions& options) {
  reset_rejections(t, segment, model);
  const WidenedArrivals widened(t, segment, model, options.range_uncertainty_m);
  CorrelatedArrivals sigmas(t, segment, model.correlated, CorrelatedArrivals::Side::kChanging);
  solve_states(t, segment, model.state, {.late_scale = 10.0, .early_scale = 15.0},
               {.max_iterations = 15, .tolerance = kNearlyConverged, .threads = options.threads});
  StateSolveResult result =
      solve_states(t, segment, model.state, {.late_scale = 2.5, .early_scale = 4.0},
                   {.max_iterations = 25, .tolerance = kNearlyConverged, .threads = options.threads});
  for (int round = 0; round < kSegmentOutlierRounds; ++round) {
    sigmas.restore();
    if (!reject_arrivals(t, segment, model, 0.0, options.rejection_sigmas) && round > 0) break;
    sigmas.weigh();
    result = solve_states(t, segment, model.state, RobustLoss{},
                          {.max_iterations = 20, .tolerance = kConverged, .threads = options.threads});
  }
  sigmas.weigh();
  return std::isfinite(result.cost);
}

Fix fix_at(const Trajectory& t, std::size_t first, std::size_t last) {
  Fix fix;
  fix.time_s = t.arrivals[first].time_s;
  fix.vehicle = t.vehicle;
  fix.epoch = t.nodes[t.arrivals[first].node].epoch;
  report_arrivals(t, first, last, fix);
  return fix;
}

/// Calls visit(first, last) for the arrivals of each distinct time, or of each epoch.
template <class Visitor>
void for_each_instant(const Trajectory& t, const Segment& segment, Visitor&& visit) {
  const auto together = [&t](const ArrivalObservation& a, const ArrivalObservation& b) {
    return t.moving ? a.time_s == b.time_s : a.node == b.node;
  };
  for (std::size_t first = segment.first_arrival; first < segment.last_arrival;) {
    std::size_t last = first;
    while (last < segment.last_arrival && together(t.arrivals[last], t.arrivals[first])) ++last;
    visit(first, last);
    first = last;
  }
}

void unlocated(const Trajectory& t, const Segment& segment, std::vector<Fix>& fixes) {
  for_each_instant(t, segment, [&](std::size_t first, std::size_t last) {
    fixes.push_back(fix_at(t, first, last));
    fixes.back().status = FixStatus::kNoConsensus;
  });
}

/// Velocity at an arrival of a moving trajectory, from the odometry around it.
std::optional<VelocityEstimate> odometry_velocity_at(const Trajectory& t, const Segment& segment,
                                                     const ArrivalObservation& a) {
  const std::size_t row = segment.first_odometry + a.node - segment.first_node;
  if (!t.moving || row >= segment.last_odometry) return std::nullopt;
  const OdometryObservation& step = t.odometry[row];
  const double span_s = t.nodes[a.node + 1].time_s - t.nodes[a.node].time_s,
               speed_variance = square(step.distance_sigma_m / span_s),
               turn_variance = square(step.heading_sigma_rad / span_s);
  VelocityEstimate velocity;
  velocity.mean << step.T_before_after.translation_m, log_rotation(step.T_before_after.rotation);
  velocity.mean /= span_s;
  velocity.variance = t.motion == Motion::kPlanar
                          ? in_space<3>(along_and_about<3>(speed_variance, turn_variance))
                          : along_and_about<6>(speed_variance, turn_variance);
  return velocity;
}

/// Returns true if it was possible.
bool track_smooth(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                  const CalibrationPart& calibration, const TrackerOptions& options,
                  std::vector<Fix>& fixes) {
  if (!place_segment(t, segment, model, options) || !smooth_segment(t, segment, model, options)) return false;
  std::vector<DriveInstant> instants;
  for_each_instant(t, segment, [&](std::size_t first, std::size_t) {
    instants.push_back({t.arrivals[first].node, t.arrivals[first].alpha});
  });
  const std::size_t before = fixes.size();
  if (instants.size() > before) fixes.reserve(before + instants.size());  // saves memory on a long drive
  for_each_instant(t, segment, [&](std::size_t first, std::size_t last) {
    const ArrivalObservation& a = t.arrivals[first];
    Fix& fix = fixes.emplace_back(fix_at(t, first, last));
    fix.T_map_vehicle = pose_at(t, a.node, a.alpha);
    fix.velocity = odometry_velocity_at(t, segment, a);
    fix.status = FixStatus::kOk;
  });
  // Fixes among roughly known beacons have no bound.
  const bool protect = options.protect && options.range_uncertainty_m == 0.0;
  set_uncertainty(t, segment, model, calibration, {protect, options.threads}, instants,
                  std::span(fixes).subspan(before));
  return true;
}

/// Uses past data only, as on a robot: odometry up to each instant, then its arrivals.
/// @return false and no fixes if the attitude in space remained open until the end
bool track_causal(const MeasurementLog& log, VehicleId vehicle, const Deployment& deployment,
                  const TrackerOptions& options, std::vector<Fix>& fixes) {
  std::vector<OdometryStep> steps;
  for (const OdometryStep& step : log.odometry)
    if (step.vehicle == vehicle) steps.push_back(step);
  std::vector<Arrival> arrivals;
  for (const Arrival& a : log.arrivals)
    if (a.vehicle == vehicle && a.time_s >= steps.front().time_s && a.time_s <= steps.back().time_s)
      arrivals.push_back(a);
  DriveTracker tracker(deployment, log.odometry_accuracy, options);
  const auto before = static_cast<std::ptrdiff_t>(fixes.size());
  std::size_t next = 0;
  for (std::size_t first = 0; first < arrivals.size();) {
    std::size_t last = first;
    while (last < arrivals.size() && arrivals[last].time_s == arrivals[first].time_s) ++last;
    while (next < steps.size() && (next == 0 || steps[next - 1].time_s < arrivals[first].time_s))
      static_cast<void>(tracker.move(steps[next++]));
    tracker.locate(Observations{std::span(arrivals).subspan(first, last - first), {}}, fixes.emplace_back());
    first = last;
  }
  const bool any = std::any_of(fixes.begin() + before, fixes.end(), [](const Fix& f) { return f.ok(); });
  if (any || deployment.motion == Motion::kPlanar) return true;
  fixes.resize(static_cast<std::size_t>(before));
  return false;
}

/// Returns true if odometry links all states of a segment.
bool is_chained(const Trajectory& t, const Segment& segment) {
  return !t.has_cycle_offset && segment.last_node - segment.first_node >= 2 &&
         segment.last_odometry - segment.first_odometry + 1 == segment.last_node - segment.first_node;
}

bool needs_tracking(const Trajectory& t, const Segment& segment) {
  if (t.motion_prior) return segment.last_node - segment.first_node >= 2;
  return t.moving && is_chained(t, segment);
}

/// Positions of a spatial drive whose attitude remains open (a single antenna on a straight path). Returns
/// false if the drive is of another kind.
bool follow_arrivals_alone(const MeasurementLog& log, const Trajectory& t, const Deployment& deployment,
                           const SpaceTrackOptions& options, std::vector<Fix>& fixes) {
  if (t.motion != Motion::kSpatial) return false;
  MeasurementLog alone = log;
  alone.odometry.clear();
  std::erase_if(alone.arrivals, [&](const Arrival& a) { return a.vehicle != t.vehicle; });
  if (!is_drive_in_space(deployment, alone)) return false;
  for (Fix& fix : track_in_space(alone, deployment, options)) fixes.push_back(std::move(fix));
  return true;
}

/// Fixes each pose of a segment from its own arrivals.
void fix_each_epoch(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                    const CalibrationPart& calibration, const TrackerOptions& options,
                    std::vector<Fix>& fixes) {
  EpochFixOptions epoch_options;
  epoch_options.rejection_sigmas = options.rejection_sigmas;
  epoch_options.range_uncertainty_m = options.range_uncertainty_m;
  for (std::size_t node = segment.first_node; node < segment.last_node; ++node) {
    const Segment epoch = node_segment(t, segment, node);
    fixes.push_back(fix_epoch(t, epoch, model, epoch_options));
    if (fixes.back().ok()) calibration.add_to(fixes.back().covariance, t, epoch, model.state);
  }
}

}  // namespace

bool place_drive(Trajectory& t, const EpochFixModel& model, const TrackerOptions& options) {
  bool any = false;
  for (const Segment& segment : t.segments) {
    if (!needs_tracking(t, segment)) continue;
    if (!place_segment(t, segment, model, options)) continue;
    const bool pieces = goes_by_pieces(t, options);
    if (pieces) reset_rejections(t, segment, model);  // the solution would follow the errors of the beacons
    any = pieces || smooth_segment(t, segment, model, options) || any;
  }
  return any;
}

std::vector<Fix> track(const MeasurementLog& all_rows, const Deployment& deployment,
                       const TrackerOptions& options) {
  MeasurementLog room;
  const MeasurementLog& log = known_rows(all_rows, deployment, room);
  const SpaceTrackOptions in_space{.rejection_sigmas = options.rejection_sigmas, .protect = options.protect};
  const bool epochs_in_space = log.has_epochs && may_track_in_space(deployment, log);
  if (epochs_in_space || is_drive_in_space(deployment, log)) return track_in_space(log, deployment, in_space);
  std::vector<Fix> fixes;
  const EpochFixModel model = epoch_fix_model(deployment);
  const CalibrationPart calibration(deployment);
  for (std::size_t v = 0; v < deployment.vehicles.size(); ++v) {
    Trajectory t = make_trajectory(log, 0, VehicleId(v), trajectory_model(deployment));
    for (const Segment& segment : t.segments) {
      const bool drive = needs_tracking(t, segment),
                 stops = !drive && t.motion == Motion::kPlanar && is_chained(t, segment);
      if (drive && !options.smooth && !t.motion_prior &&
          track_causal(log, VehicleId(v), deployment, options, fixes))
        continue;
      TrackerOptions search = options;
      // Stops may be minutes apart, so the required number does not depend on time.
      if (stops)
        search.max_start_window_s =
            std::max(options.max_start_window_s,
                     t.nodes[segment.last_node - 1].time_s - t.nodes[segment.first_node].time_s);
      if ((drive || stops) && track_smooth(t, segment, model, calibration, search, fixes)) continue;
      if (drive) {
        if (!follow_arrivals_alone(log, t, deployment, in_space, fixes)) unlocated(t, segment, fixes);
      } else {
        fix_each_epoch(t, segment, model, calibration, options, fixes);
      }
    }
  }
  std::ranges::stable_sort(fixes, {}, &Fix::time_s);
  return fixes;
}

}  // namespace octant
