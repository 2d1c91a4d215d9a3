// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "calib/problem/log_health.h"
#include "calib/statements/common_errors.h"
#include "calib/statements/measured_path.h"
#include "calib/statements/receiver_pattern.h"

namespace octant::calib {
namespace {

using Kind = CommonError::Kind;
using Span = std::pair<double, double>;

Contradiction of_shift(const CommonError& e, const MeasurementLog& run) {
  const Eigen::Vector3d shift_m = e.size * e.along, back_m = -shift_m;
  const auto in_metres = [](const Eigen::Vector3d& p_m) {
    return p_m.z() == 0.0 ? fmt::format("({:.3f}, {:.3f}) m", p_m.x(), p_m.y())
                          : fmt::format("({:.3f}, {:.3f}, {:.3f}) m", p_m.x(), p_m.y(), p_m.z());
  };
  return {ContradictionKind::kPoses,
          "in " + run.path + "/" + pose_file(run),
          "poses in one frame throughout",
          fmt::format("that from {:.6g} s on they are shifted by {}", e.time_s, in_metres(shift_m)),
          e.sigmas,
          fmt::format("check if the instrument was set up again at that time; shift the later poses by {}, "
                      "or leave them out",
                      in_metres(back_m))};
}

Contradiction of_lag(const CommonError& e, const std::string& file) {
  const bool late = e.size > 0;
  return {ContradictionKind::kPoses,
          "in " + file,
          "times by the clock of the arrivals",
          fmt::format("that they are stamped {:.3g} s {}", std::abs(e.size), late ? "late" : "early"),
          e.sigmas,
          fmt::format("check how the two clocks are synchronised, or {} {:.3g} s {} each time of {}",
                      late ? "subtract" : "add", std::abs(e.size), late ? "from" : "to", file)};
}

Contradiction of_pattern(const CommonError& e) {
  return {ContradictionKind::kReceiver,
          "patterns",
          "alike in all directions",
          fmt::format("that ranges are {:.3g} mm {} to beacons in front of them than to beacons behind them, "
                      "as the patterns of antennas and transducers cause",
                      2e3 * std::abs(e.size), e.size > 0 ? "longer" : "shorter"),
          e.sigmas,
          "if accuracy of this size matters, calibrate the devices by direction, or mount them so that they "
          "face the beacons alike"};
}

std::string longer_by(double step_s) {
  return fmt::format("{:.4g} ms {}", 1e3 * std::abs(step_s), step_s > 0 ? "longer" : "shorter");
}

Contradiction of_odometry(const CommonError& e, const std::string& file) {
  const bool turns = e.kind == Kind::kTurns, much = e.size > 0;
  return {
      ContradictionKind::kLog,
      file,
      "true metres and radians of the motion",
      fmt::format("that {} {:.2g} % too {}", turns ? "its turns are" : "its way is", 100 * std::abs(e.size),
                  turns ? (much ? "large" : "small") : (much ? "long" : "short")),
      e.sigmas,
      fmt::format("check {}, or multiply {} by {:.4g}",
                  turns ? "the distance between the wheels, or the gyroscope" : "the diameter of the wheels",
                  turns ? "dheading_rad" : "dx_m and dy_m", 1.0 / (1.0 + e.size))};
}

Contradiction of_speed(const CommonError& e, const Site& site, const std::string& path) {
  const double speed = speed_mps(site.medium),
               per_degree = speed_mps(site.medium, site.medium.temperature_degC + 1) - speed;
  const std::string air =
      per_degree > 0 ? fmt::format(", as in air that {} by {:.2g} degC", e.size > 0 ? "warms" : "cools",
                                   std::abs(e.size) * speed / per_degree)
                     : "";
  return {ContradictionKind::kLog,
          path,
          "the medium in one state throughout",
          fmt::format("that sound is {:.2g} % {} at its end than at its beginning{}", 100 * std::abs(e.size),
                      e.size > 0 ? "faster" : "slower", air),
          e.sigmas,
          "log the temperature with the arrivals (temperature_degC in tof.csv), or make a recording of each "
          "part and state its temperature in run.yaml"};
}

}  // namespace

std::string jump_in_words(double time_s, double step_s) {
  return fmt::format("from {:.6g} s on times of flight are {}", time_s, longer_by(step_s));
}

Contradiction contradiction_of(const CommonError& e, const Site& site,
                               const std::vector<MeasurementLog>& runs) {
  const std::string& path = runs[e.run].path;
  if (is_of_odometry(e)) return of_odometry(e, path + "/odometry.csv");
  if (e.kind == Kind::kSpeed) return of_speed(e, site, path);
  if (e.kind == Kind::kShift) return of_shift(e, runs[e.run]);
  if (e.kind == Kind::kLag) return of_lag(e, path + "/" + pose_file(runs[e.run]));
  if (e.kind == Kind::kPattern) return of_pattern(e);
  if (e.kind == Kind::kDrift)
    return {
        ContradictionKind::kLog,
        path,
        "one clock throughout",
        fmt::format("that it drifts: times of flight are {} at its end than at its beginning",
                    longer_by(e.size)),
        e.sigmas,
        "check how beacons and receivers are synchronised, and let the electronics warm up before recording"};
  return {ContradictionKind::kLog,
          path,
          "one clock throughout",
          "that it jumped: " + jump_in_words(e.time_s, e.size),
          e.sigmas,
          "check how beacons and receivers are synchronised (a restart, a lost pulse), and leave out the "
          "rows before the jump or after it"};
}

void take_back(const CommonError& e, const SharedState& state, std::vector<Trajectory>& trajectories) {
  Span span_s{INFINITY, -INFINITY};
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals)
      if (t.run == e.run) span_s = {std::min(span_s.first, a.time_s), std::max(span_s.second, a.time_s)};
  const double factor = 1.0 / (1.0 + e.size);
  for (Trajectory& t : trajectories) {
    if (is_of_odometry(e)) {
      for (OdometryObservation& o : t.odometry) {
        if (e.kind == Kind::kWay) o.T_before_after.translation_m *= factor;
        if (e.kind == Kind::kTurns)
          o.T_before_after.rotation =
              Pose::planar(0.0, 0.0, factor * o.T_before_after.heading_rad()).rotation;
      }
      continue;
    }
    if (e.kind == Kind::kPattern) {
      const ReceiverPattern pattern(t, state);
      for (ArrivalObservation& a : t.arrivals) a.tof_s -= e.size * pattern.delay_s(a);
      continue;
    }
    if (t.run != e.run) continue;
    if (e.kind == Kind::kLag && t.moving && t.poses.size() >= 2) {
      const Trajectory as_measured = t;
      const MeasuredPath path(as_measured);
      for (PoseObservation& p : t.poses) p.T_map_vehicle = path.at(time_of(t, p) + e.size);
    }
    if (e.kind == Kind::kShift)
      for (PoseObservation& p : t.poses)
        if (time_of(t, p) >= e.time_s) p.T_map_vehicle.translation_m -= e.size * e.along;
    for (ArrivalObservation& a : t.arrivals) {
      if (e.kind == Kind::kSpeed) a.tof_s /= 1.0 - e.size * share_of_span(span_s, a.time_s);
      if (e.kind == Kind::kDrift) a.tof_s -= e.size * share_of_span(span_s, a.time_s);
      if (e.kind == Kind::kJump && a.time_s >= e.time_s) a.tof_s -= e.size;
    }
  }
}

void take_back(const CommonError& e, Span span_s, MeasurementLog& run) {
  const double factor = 1.0 / (1.0 + e.size);
  if (is_of_odometry(e)) {
    for (OdometryStep& step : run.odometry) {
      if (e.kind == Kind::kTurns) step.dheading_rad *= factor;
      if (e.kind == Kind::kWay) step.dx_m *= factor, step.dy_m *= factor, step.way_m *= factor;
    }
    return;
  }
  if (e.kind == Kind::kShift) {
    for (TimedPose& pose : run.poses)
      if (pose.time_s >= e.time_s) pose.T_map_vehicle.translation_m -= e.size * e.along;
    return;
  }
  if (e.kind == Kind::kLag) {
    for (TimedPose& pose : run.poses) pose.time_s -= e.size;
    return;
  }
  for (Arrival& a : run.arrivals) {
    if (e.kind == Kind::kSpeed) a.tof_s /= 1.0 - e.size * share_of_span(span_s, a.time_s);
    if (e.kind == Kind::kDrift) a.tof_s -= e.size * share_of_span(span_s, a.time_s);
    if (e.kind == Kind::kJump && a.time_s >= e.time_s) a.tof_s -= e.size;
  }
}

Span span_of(const std::vector<Arrival>& arrivals) {
  Span span_s{INFINITY, -INFINITY};
  for (const Arrival& a : arrivals)
    span_s = {std::min(span_s.first, a.time_s), std::max(span_s.second, a.time_s)};
  return span_s;
}

}  // namespace octant::calib
