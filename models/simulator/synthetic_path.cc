// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/simulator/synthetic_path.h"

#include <algorithm>
#include <cmath>

namespace octant {
namespace {

constexpr double kStart_s = 10.0;
constexpr double kSample_s =
    0.005;  // of a drive: 3 mm at 0.6 m/s; deviation from the arc between samples is 1 micrometre
constexpr double kTilt_rad = 0.05;  // spatial motion only
constexpr double kHeave_m = 0.1;
constexpr double kHeadingScatter_rad =
    0.3;  // turns between stops, so that heading and position are not correlated

using Point = Eigen::Vector2d;

std::vector<Pose> lissajous_stops(const Scenario& scenario, int epochs, Random& draws) {
  const Point hall(scenario.hall_m[0], scenario.hall_m[1]);
  const Point reach = hall / 2 - Point::Constant(0.1 * hall.minCoeff());
  // One draw for each statement, here and elsewhere: the order of evaluation of arguments differs between
  // compilers.
  const double phase_y = draws.uniform(0, 2 * M_PI), phase_x = draws.uniform(0, 2 * M_PI);
  const Point phase(phase_x, phase_y);
  const Point turns(3.0, 4.0);  // closed, and dense enough to visit the whole hall
  std::vector<Pose> stops;
  for (int k = 0; k < epochs; ++k) {
    const Point angle = phase + 2 * M_PI * k / epochs * turns;
    const Point p = hall / 2 + reach.cwiseProduct(Point(std::sin(angle.x()), std::sin(angle.y())));
    const Point v = reach.cwiseProduct(turns).cwiseProduct(Point(std::cos(angle.x()), std::cos(angle.y())));
    stops.push_back(
        Pose::planar(p.x(), p.y(), std::atan2(v.y(), v.x()) + kHeadingScatter_rad * draws.normal()));
  }
  return stops;
}

std::vector<Pose> polyline_stops(const std::vector<Point>& corners, int epochs) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < corners.size(); ++i) length_m += (corners[i] - corners[i - 1]).norm();
  std::vector<Pose> stops;
  std::size_t leg = 1;
  double leg_start_m = 0.0;
  for (int k = 0; k < epochs; ++k) {
    const double s = epochs > 1 ? length_m * k / (epochs - 1) : 0.0;
    double leg_m = (corners[leg] - corners[leg - 1]).norm();
    while (s > leg_start_m + leg_m && leg + 1 < corners.size()) {
      leg_start_m += leg_m;
      ++leg;
      leg_m = (corners[leg] - corners[leg - 1]).norm();
    }
    const Point along = (corners[leg] - corners[leg - 1]) / leg_m;
    const Point p = corners[leg - 1] + std::min(s - leg_start_m, leg_m) * along;
    stops.push_back(Pose::planar(p.x(), p.y(), std::atan2(along.y(), along.x())));
  }
  return stops;
}

std::vector<Pose> given_stops(const std::vector<Eigen::Vector3d>& stations, int epochs) {
  std::vector<Pose> stops;
  for (int k = 0; k < epochs; ++k) {
    const Eigen::Vector3d& s = stations[static_cast<std::size_t>(k) % stations.size()];
    stops.push_back(Pose::planar(s.x(), s.y(), s.z()));
  }
  return stops;
}

/// Drives from goal to goal at constant speed, steering towards the goal with a limited turn rate.
std::vector<Pose> drive(const Scenario& scenario, const Scenario::Path& path, Random& draws) {
  std::size_t next = 0;
  const auto goal = [&]() -> Point {
    if (!path.waypoints_m.empty()) return path.waypoints_m[next++ % path.waypoints_m.size()];
    Point p;
    for (int i = 0; i < 2; ++i) {
      const double margin = std::min(2.0, scenario.hall_m[i] / 4);
      p[i] = draws.uniform(margin, scenario.hall_m[i] - margin);
    }
    return p;
  };
  // The vehicle would orbit a goal inside its turning circle forever.
  const double reached_m = 2.1 * path.speed_mps / path.turn_rate_rad_per_s;
  Point p = goal();
  Point target = goal();
  double heading = std::atan2(target.y() - p.y(), target.x() - p.x());
  std::vector<Pose> poses;
  const auto samples = static_cast<std::size_t>(std::ceil(path.duration_s / kSample_s)) + 1;
  for (std::size_t i = 0; i < samples; ++i) {
    poses.push_back(Pose::planar(p.x(), p.y(), heading));
    if ((target - p).norm() < reached_m) target = goal();
    const double off = wrap_angle(std::atan2(target.y() - p.y(), target.x() - p.x()) - heading);
    const double turn =
        kSample_s * std::clamp(1.5 * off, -path.turn_rate_rad_per_s, path.turn_rate_rad_per_s);
    p += kSample_s * path.speed_mps * Point(std::cos(heading + turn / 2), std::sin(heading + turn / 2));
    heading += turn;
  }
  return poses;
}

void tilt(Pose& pose, double roll, double pitch, double heave) {
  pose.translation_m.z() += kHeave_m * heave;
  pose.rotation = pose.rotation * exp_rotation(kTilt_rad * Eigen::Vector3d(roll, pitch, 0.0));
}

void make_spatial(TruePath& path, Random& draws) {
  for (std::size_t i = 0; i < path.poses.size(); ++i) {
    if (path.moving) {  // slow swaying that can be interpolated
      const double a = 2 * M_PI * path.period_s * static_cast<double>(i);
      tilt(path.poses[i], std::sin(0.31 * a), std::sin(0.23 * a), std::sin(0.11 * a));
    } else {
      const Eigen::Vector3d d = draws.normal3();
      tilt(path.poses[i], d.x(), d.y(), d.z());
    }
  }
}

}  // namespace

Pose TruePath::at(double time_s) const {
  const double steps = std::clamp((time_s - start_s) / period_s, 0.0, static_cast<double>(poses.size() - 1));
  const auto i = static_cast<std::size_t>(steps);
  if (!moving || i + 1 == poses.size()) return poses[i];
  return interpolate(poses[i], poses[i + 1], steps - static_cast<double>(i));
}

TruePath make_path(const Scenario& scenario, const Scenario::Path& path, Random& draws) {
  TruePath result{.moving = path.kind == PathKind::kDrive,
                  .start_s = kStart_s,
                  .period_s = path.kind == PathKind::kDrive ? kSample_s : path.epoch_period_s,
                  .poses = {}};
  switch (path.kind) {
    case PathKind::kStops: result.poses = lissajous_stops(scenario, path.epochs, draws); break;
    case PathKind::kWaypoints: result.poses = polyline_stops(path.waypoints_m, path.epochs); break;
    case PathKind::kStations: result.poses = given_stops(path.stations, path.epochs); break;
    case PathKind::kDrive: result.poses = drive(scenario, path, draws); break;
  }
  if (scenario.site.motion == Motion::kSpatial) make_spatial(result, draws);
  return result;
}

}  // namespace octant
