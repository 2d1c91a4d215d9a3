// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/simulator/synthetic_sensors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "models/physics/measurement.h"
#include "models/physics/plane.h"
#include "models/simulator/synthetic_path.h"

namespace octant {
namespace {

/// Instants of measurement: the start of each stop, or periodic along a drive.
struct Instant {
  double time_s = 0.0;
  std::int64_t epoch = kNoEpoch;
};
std::vector<Instant> instants(const Scenario::Path& spec, const TruePath& path, double period_s) {
  std::vector<Instant> all;
  if (!path.moving) {
    for (int k = 0; k < spec.epochs; ++k)
      all.push_back({to_microsecond(path.start_s + k * path.period_s), k});
    return all;
  }
  for (int i = 0; path.start_s + i * period_s <= path.end_s() - spec.odometry_period_s; ++i)
    all.push_back({to_microsecond(path.start_s + i * period_s), kNoEpoch});
  return all;
}

void record_bearings(const Scenario& scenario, const std::vector<Instant>& times, const TruePath& path,
                     const SharedState& truth, Random& draws, MeasurementLog& log) {
  const Scenario::Bearings& spec = *scenario.bearings;
  for (const Instant& now : times) {
    const Pose T = path.at(now.time_s);
    for (std::size_t b = 0; b < truth.beacon_p_map_m.size(); ++b) {
      // Draws for every reflector, visible or not, so that streams stay aligned.
      const double noise = draws.normal(), label = draws.uniform();
      const Eigen::Vector3d& p = truth.beacon_p_map_m[b];
      if ((p - T.translation_m).head<2>().norm() > spec.range_m) continue;
      Bearing bearing;
      bearing.time_s = now.time_s;
      bearing.vehicle = VehicleId(std::size_t{0});
      bearing.epoch = now.epoch;
      const double true_rad = predict_bearing(T, p, Eigen::Vector3d::Zero()).bearing_rad;
      bearing.bearing_rad = wrap_angle(true_rad + scenario.site.noise.bearing_sigma_rad * noise);
      if (label >= spec.unlabelled_fraction) bearing.reflector = BeaconId(b);
      log.bearings.push_back(bearing);
      log.bearings.back().line = static_cast<int>(log.bearings.size()) + 1;  // line below the header
    }
  }
}

/// Distance along a ray to the nearest wall; infinite if there is none.
double range_to_wall(const Scenario& scenario, const Eigen::Vector2d& from,
                     const Eigen::Vector2d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [x1, y1, x2, y2] : scenario.walls_m) {
    const Eigen::Vector2d along(x2 - x1, y2 - y1), to = Eigen::Vector2d(x1, y1) - from;
    const double det = cross(direction, along);
    if (det == 0) continue;
    const double range = cross(to, along) / det, part = cross(to, direction) / det;
    if (range > 0 && part >= 0 && part <= 1) nearest = std::min(nearest, range);
  }
  return nearest;
}

void record_scans(const Scenario& scenario, const std::vector<Instant>& times, const TruePath& path,
                  Random& draws, MeasurementLog& log) {
  const Scenario::Scans& spec = *scenario.scans;
  for (const Instant& now : times) {
    const Pose T = path.at(now.time_s);
    Scan scan{.time_s = now.time_s,
              .angle_min_rad = spec.angle_min_rad,
              .angle_increment_rad = spec.angle_increment_rad,
              .range_m = {}};
    for (int k = 0; k < spec.beams; ++k) {
      const double angle = T.heading_rad() + spec.angle_min_rad + k * spec.angle_increment_rad;
      const double range = range_to_wall(scenario, T.translation_m.head<2>(), direction_of(angle));
      const double measured = range + scenario.site.noise.range_sigma_m * draws.normal();
      const bool is_seen = range < spec.range_max_m && measured > 0;
      // Rounded to millimetres, like real scanners.
      scan.range_m.push_back(is_seen ? std::round(measured * 1000) / 1000
                                     : std::numeric_limits<double>::quiet_NaN());
    }
    log.scans.push_back(std::move(scan));
  }
}

}  // namespace

void record_sensors(const Scenario& scenario, const Scenario::Path& spec, const TruePath& path,
                    const SharedState& truth, Random draws, MeasurementLog& log) {
  if (scenario.bearings)
    record_bearings(scenario, instants(spec, path, scenario.bearings->period_s), path, truth, draws, log);
  if (scenario.scans)
    record_scans(scenario, instants(spec, path, scenario.scans->period_s), path, draws, log);
}

Result<void> check_sensors(const Scenario& scenario) {
  if (scenario.bearings) {
    const Scenario::Bearings& b = *scenario.bearings;
    if (!(b.range_m > 0 && b.period_s > 0))
      return bad_input("bearings: range_m or period_s is not positive", "numbers above zero");
    if (!(b.unlabelled_fraction >= 0 && b.unlabelled_fraction <= 1))
      return bad_input("bearings.unlabelled_fraction out of range", "0 <= fraction <= 1");
    if (scenario.site.beacons.empty())
      return bad_input("bearings without reflectors", "beacons in the site, which are the reflectors");
  }
  if (scenario.scans) {
    const Scenario::Scans& s = *scenario.scans;
    if (!(s.period_s > 0 && s.range_max_m > 0 && s.beams > 0))
      return bad_input("scans: period_s, range_max_m or beams is not positive", "numbers above zero");
    if (scenario.walls_m.empty()) return bad_input("scans without walls_m", "walls to be seen");
  }
  for (const auto& [x1, y1, x2, y2] : scenario.walls_m)
    if (x1 == x2 && y1 == y2)
      return bad_input("walls_m: a wall without length", "[x1, y1, x2, y2], two distinct ends");
  if ((scenario.bearings || scenario.scans) && scenario.site.motion != Motion::kPlanar)
    return bad_input("bearings or scans with spatial motion", "motion: planar");
  return {};
}

}  // namespace octant
