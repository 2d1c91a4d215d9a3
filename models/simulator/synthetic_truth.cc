// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/simulator/synthetic_truth.h"

#include <algorithm>
#include <cmath>

#include "models/simulator/synthetic_sensors.h"

namespace octant {
namespace {

Result<void> check_path(const Scenario& scenario, const Scenario::Path& path, const std::string& key) {
  if (!(path.slot_s > 0 && path.epoch_period_s > 0))
    return bad_input(key + ": a period is not positive", "seconds above zero");
  for (std::size_t i = 1; i < path.waypoints_m.size(); ++i) {
    if (path.waypoints_m[i] == path.waypoints_m[i - 1]) {
      return bad_input(key + ".waypoints_m: number " + std::to_string(i + 1) + " repeats the one before",
                       "distinct points");
    }
  }
  if (path.kind == PathKind::kDrive) {
    if (scenario.site.timing.clock == Clock::kCycleOffset) {
      return bad_input(key + ": a drive has no epochs", "kind stops or waypoints with clock cycle_offset");
    }
    if (!(path.speed_mps > 0 && path.turn_rate_rad_per_s > 0 && path.odometry_period_s > 0 &&
          path.duration_s > path.slot_s)) {
      return bad_input(key + ": the drive does not move",
                       "positive duration_s, speed_mps, turn_rate_rad_per_s, odometry_period_s");
    }
    if (path.waypoints_m.size() == 1)
      return bad_input(key + ".waypoints_m: one point", "none, or two or more");
    return {};
  }
  if (path.epochs < 1 || path.rounds < 1)
    return bad_input(key + ": no epochs", "epochs and rounds of at least 1");
  if (path.kind == PathKind::kWaypoints && path.waypoints_m.size() < 2) {
    return bad_input(key + ": kind waypoints without waypoints_m", "two points or more");
  }
  if (path.kind == PathKind::kStations && path.stations.empty()) {
    return bad_input(key + ": kind stations without stations", "[x_m, y_m, heading_rad] of at least one");
  }
  if (dwell_s(scenario, path) >= path.epoch_period_s) {
    return bad_input(key + ": arrivals of an epoch last " + std::to_string(dwell_s(scenario, path)) + " s",
                     "a longer epoch_period_s than that");
  }
  return {};
}

double speed_offset(const Scenario& scenario, Random& draws) {
  const double drawn = scenario.site.speed_sigma_mps * draws.clipped_normal();
  if (scenario.true_speed_offset_mps) return *scenario.true_speed_offset_mps;
  if (!scenario.true_temperature_offset_degC) return drawn;
  const Medium& medium = scenario.site.medium;
  return speed_mps(medium, medium.temperature_degC + *scenario.true_temperature_offset_degC) -
         speed_mps(medium);
}

double draw(const Prior& prior, Random& draws) { return prior.value + prior.sigma * draws.clipped_normal(); }

double round_to_micrometre(double x) { return std::round(x * 1e6) / 1e6; }

}  // namespace

double dwell_s(const Scenario& scenario, const Scenario::Path& path) {
  const Timing& timing = scenario.site.timing;
  const double legs = timing.legs();
  const double flight_s = legs * scenario.range_m / speed_mps(scenario.site.medium) + timing.turnaround_s;
  const double late_s = scenario.echo_fraction > 0 ? scenario.echo_delay_s[1] : 0.0;
  const double firings = static_cast<double>(scenario.site.beacons.size()) * path.rounds;
  // One additional slot covers delays and time-walk.
  return kTruthPeriod_s * std::ceil((path.slot_s * (firings + 1) + flight_s + late_s) / kTruthPeriod_s);
}

Result<void> check_scenario(const Scenario& scenario) {
  const Site& site = scenario.site;
  if (site.vehicles.empty() || site.vehicles[0].receiver_count == 0)
    return bad_input("site: no vehicle with receivers", "one");
  for (const SiteBeacon& beacon : site.beacons) {
    if (!beacon.position_m[0] || !beacon.position_m[1] || !beacon.position_m[2]) {
      return bad_input("beacon '" + beacon.name + "' has no position",
                       "its true position, with sigma_m null if people do not know it");
    }
  }
  if (scenario.log_amplitude && !site.attenuation) {
    return bad_input("log_amplitude without a model of the amplitude", "an attenuation block in the site");
  }
  if (scenario.warming_degC != 0 && site.medium.model == MediumModel::kConstant) {
    return bad_input("warming_degC in a medium of constant speed",
                     "medium.model cramer1993 or linear_temperature");
  }
  if (!(scenario.echo_fraction >= 0 && scenario.echo_fraction < 1 && scenario.early_fraction >= 0 &&
        scenario.early_fraction < 1)) {
    return bad_input("echo_fraction or early_fraction out of range", "0 <= fraction < 1");
  }
  if (!(scenario.echo_delay_s[0] > 0 && scenario.echo_delay_s[1] >= scenario.echo_delay_s[0])) {
    return bad_input("echo_delay_s is not an interval above zero", "[shortest, longest]");
  }
  if (!(scenario.hall_m[0] > 0 && scenario.hall_m[1] > 0 && scenario.range_m > 0)) {
    return bad_input("hall_m or range_m is not positive", "metres above zero");
  }
  if (auto sound = check_sensors(scenario); !sound) return sound;
  if (auto sound = check_path(scenario, scenario.path, "path"); !sound) return sound;
  return check_path(scenario, scenario.heldout_path, "heldout_path");
}

namespace {

/// Scales and turns the receivers of a vehicle as a whole.
void shape_array(const Site& site, std::size_t vehicle, Random& draws, SharedState& truth) {
  const SiteVehicle& v = site.vehicles[vehicle];
  const double wider_m = v.array->radius_sigma_m * draws.clipped_normal(),
               turn_rad = v.array->turn_sigma_rad * draws.clipped_normal();
  const double radius_m =
      v.receiver_count > 0 ? truth.receiver_p_vehicle_m[v.first_receiver].head<2>().norm() : 0.0;
  if (!(radius_m > 0)) return;
  const Eigen::Matrix2d shape = (1 + wider_m / radius_m) * Eigen::Rotation2Dd(turn_rad).toRotationMatrix();
  for (std::size_t r = v.first_receiver; r < v.first_receiver + v.receiver_count; ++r)
    truth.receiver_p_vehicle_m[r].head<2>() = (shape * truth.receiver_p_vehicle_m[r].head<2>()).eval();
}

}  // namespace

SharedState draw_truth(const Scenario& scenario, Random& draws) {
  const Site& site = scenario.site;
  const Timing& timing = site.timing;
  // The prior mean is assigned to the first kind of delay in use (as in prior_state); further kinds scatter
  // about zero.
  const DelayPer& per = timing.delay_per;
  const auto delay = [&](bool is_unknown, bool is_first) {
    if (!is_unknown) return 0.0;
    if (!scenario.true_delay_s)
      return (is_first ? timing.delay_s : 0.0) + timing.delay_sigma_s * draws.clipped_normal();
    const auto [low_s, high_s] = *scenario.true_delay_s;
    return draws.uniform(low_s, high_s) - (is_first ? 0.0 : (low_s + high_s) / 2);
  };
  SharedState truth;
  truth.speed_offset_mps = {speed_offset(scenario, draws)};
  for (const SiteBeacon& beacon : site.beacons) {
    truth.beacon_p_map_m.emplace_back(*beacon.position_m[0], *beacon.position_m[1], *beacon.position_m[2]);
    const bool states_its_own = beacon.delay_s || beacon.delay_sigma_s;
    const Prior own = beacon_delay_prior(site, truth.beacon_delay_s.size());
    truth.beacon_delay_s.push_back(per.beacon && states_its_own
                                       ? own.value + own.sigma * draws.clipped_normal()
                                       : delay(per.beacon, true));
  }
  for (const SiteReceiver& receiver : site.receivers) {
    Eigen::Vector3d error;
    for (int i = 0; i < 3; ++i) error[i] = receiver.sigma_m[i] * draws.clipped_normal();
    truth.receiver_p_vehicle_m.push_back(receiver.position_m + error);
    truth.receiver_delay_s.push_back(delay(per.receiver, !per.beacon));
  }
  truth.site_delay_s = per.none() ? timing.delay_s : delay(per.site, !per.beacon && !per.receiver);
  if (site.attenuation) {
    truth.attenuation = AttenuationModel{
        .amplitude_1m_v = draw(site.attenuation->amplitude_1m_v, draws),
        .absorption_np_per_m = std::max(0.0, draw(site.attenuation->absorption_np_per_m, draws)),
        .threshold_v = site.attenuation->threshold_v,
        .rise_time_s = std::max(0.0, draw(site.attenuation->rise_time_s, draws)),
        .saturation_v = site.attenuation->saturation_v};
    if (site.attenuation->half_power_angle_rad.value >
        0)  // no draw without a gain, so that existing worlds do not change
      truth.attenuation->half_power_angle_rad =
          std::clamp(draw(site.attenuation->half_power_angle_rad, draws), kLeastHalfPowerAngle_rad,
                     kMostHalfPowerAngle_rad);
    truth.receiver_axis = prior_state(site).receiver_axis;
  }
  if (site.noise.pair_sigma_s) {
    truth.pair_bias_s.resize(site.beacons.size() * site.receivers.size());
    for (double& bias : truth.pair_bias_s) bias = *site.noise.pair_sigma_s * draws.normal();
  }
  for (std::size_t v = 0; v < site.vehicles.size(); ++v) {
    truth.clock_drift.push_back(timing.drift +
                                (timing.drift_sigma > 0 ? timing.drift_sigma * draws.clipped_normal() : 0.0));
    if (site.vehicles[v].array) shape_array(site, v, draws, truth);
  }
  return truth;
}

Site known_site(const Scenario& scenario, const SharedState& truth, Random& draws) {
  Site site = scenario.site;
  site.path.clear();
  for (SiteBeacon& beacon : site.beacons) {
    const bool is_unknown = scenario.unknown_beacons && !beacon.is_control_point();
    for (std::size_t i = 0; i < 3; ++i) {
      const double error = draws.normal();
      if (is_unknown) beacon.sigma_m[i].reset();
      if (!beacon.sigma_m[i]) {
        beacon.position_m[i].reset();
      } else if (*beacon.sigma_m[i] > 0) {
        *beacon.position_m[i] = round_to_micrometre(*beacon.position_m[i] + *beacon.sigma_m[i] * error);
      }
    }
  }
  for (ControlDistance& tape : site.distances) {
    const double length_m =
        (truth.beacon_p_map_m[tape.from.index()] - truth.beacon_p_map_m[tape.to.index()]).norm();
    tape.distance_m = round_to_micrometre(length_m + tape.sigma_m * draws.normal());
  }
  return site;
}

Deployment true_deployment(const Scenario& scenario, const SharedState& truth, std::size_t arrivals) {
  const Site& site = scenario.site;
  Deployment d;
  d.site = site.name;
  d.created = "1970-01-01T00:00:00Z";  // fixed date, so that a simulated truth is reproducible
  d.motion = site.motion;
  d.datum = {.description = "Simulated truth.",
             .position = "truth",
             .orientation = "truth",
             .scale = "truth",
             .control_points = {}};
  d.medium = site.medium;
  d.speed_offset_mps = truth.speed_offset_mps[0];
  d.timing = site.timing;
  d.noise = site.noise;
  d.attenuation = truth.attenuation;
  for (std::size_t b = 0; b < site.beacons.size(); ++b) {
    const bool is_control_point = site.beacons[b].is_control_point();
    if (is_control_point) d.datum.control_points.push_back(site.beacons[b].name);
    DeploymentBeacon beacon;
    beacon.name = site.beacons[b].name;
    beacon.position_m = truth.beacon_p_map_m[b];
    beacon.delay_s = truth.site_delay_s + truth.beacon_delay_s[b];
    beacon.status = is_control_point ? BeaconStatus::kControlPoint : BeaconStatus::kCalibrated;
    d.beacons.push_back(beacon);
  }
  d.vehicles = site.vehicles;
  for (std::size_t v = 0; v < d.vehicles.size() && v < truth.clock_drift.size(); ++v)
    d.vehicles[v].clock_drift = truth.clock_drift[v];
  for (std::size_t r = 0; r < site.receivers.size(); ++r) {
    const SiteReceiver& receiver = site.receivers[r];
    d.receivers.push_back({.name = receiver.name,
                           .vehicle = receiver.vehicle,
                           .position_m = truth.receiver_p_vehicle_m[r],
                           .delay_s = truth.receiver_delay_s[r],
                           .axis = receiver.axis});
  }
  d.statistics = {.arrivals = arrivals,
                  .redundancy = static_cast<double>(arrivals),
                  .variance_factor = 1.0,
                  .chi2_p = 1.0,
                  .rms_s = site.noise.tof_sigma_s,
                  .converged = true};
  d.tolerance = site.tolerance;
  const double t = site.medium.temperature_degC;
  const double swing = std::abs(scenario.warming_degC) / 2;
  d.validity_temperature_degC = {t - swing, t + swing};
  const auto [lx, ly] = scenario.hall_m;
  d.validity_area_m = {{0.0, 0.0}, {lx, 0.0}, {lx, ly}, {0.0, ly}};
  return d;
}

}  // namespace octant
