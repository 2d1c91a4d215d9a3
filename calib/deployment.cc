// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "calib/calibrate.h"
#include "calib/problem/ranges.h"
#include "calib/solution/variances.h"
#include "calib/verdict/validity.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

void add_beacons(const Problem& problem, const Solution& solution, const Variances& variances,
                 Deployment& d) {
  // A common delay of the site is added to each beacon; biases of pairs belong to a pair and are omitted.
  for (std::size_t b = 0; b < problem.site.beacons.size(); ++b) {
    DeploymentBeacon beacon;
    beacon.name = problem.site.beacons[b].name;
    beacon.position_m = solution.state.beacon_p_map_m[b];
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        beacon.covariance_m2(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            variances.covariance(parameters::beacon_position(b, i), parameters::beacon_position(b, j));
    beacon.delay_s = solution.state.beacon_delay_s[b] + solution.state.site_delay_s;
    beacon.delay_sigma_s =
        std::hypot(variances.sigma(parameters::beacon_delay(b)), variances.sigma(parameters::site_delay()));
    beacon.status = solution.beacon_status[b];
    d.beacons.push_back(std::move(beacon));
  }
}

void add_receivers(const Problem& problem, const Solution& solution, const Variances& variances,
                   Deployment& d) {
  d.vehicles = problem.site.vehicles;
  for (std::size_t v = 0; v < d.vehicles.size() && v < solution.state.clock_drift.size(); ++v) {
    d.vehicles[v].clock_drift = solution.state.clock_drift[v];
    d.vehicles[v].clock_drift_sigma = variances.sigma(parameters::clock_drift(v));
  }
  for (std::size_t r = 0; r < problem.site.receivers.size(); ++r) {
    const SiteReceiver& given = problem.site.receivers[r];
    DeploymentReceiver receiver;
    receiver.name = given.name;
    receiver.vehicle = given.vehicle;
    receiver.axis = given.axis;
    receiver.position_m = solution.state.receiver_p_vehicle_m[r];
    receiver.position_m.head<2>() += given.taken_off_m;
    for (std::size_t i = 0; i < 3; ++i)
      receiver.sigma_m[static_cast<Eigen::Index>(i)] = variances.sigma(parameters::receiver_position(r, i));
    const std::size_t vehicle = given.vehicle.index();
    const Eigen::Vector2d o = receiver.position_m.head<2>();
    if (problem.site.vehicles[vehicle].array && o.norm() > 0) {
      Eigen::Matrix2d by_shape;  // derivatives by circumradius and rotation
      by_shape << o.x() / o.norm(), -o.y(), o.y() / o.norm(), o.x();
      const ParameterId radius = parameters::array_radius(vehicle), turn = parameters::array_turn(vehicle);
      Eigen::Matrix2d C;
      C << variances.covariance(radius, radius), variances.covariance(radius, turn),
          variances.covariance(turn, radius), variances.covariance(turn, turn);
      receiver.sigma_m.head<2>() = (by_shape * C * by_shape.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
    }
    receiver.delay_s = solution.state.receiver_delay_s[r];
    receiver.delay_sigma_s = variances.sigma(parameters::receiver_delay(r));
    d.receivers.push_back(std::move(receiver));
  }
}

/// Estimates the angle off their axes within which the receivers receive. All receivers of a vehicle share
/// one cone, so a few hundred arrivals determine it.
void add_hearing(const Solution& solution, Deployment& d) {
  constexpr std::size_t kEnough = 200;
  constexpr double kOutliers = 0.005, kMargin = 0.03;
  // For a long log, evenly spread arrivals suffice.
  constexpr std::size_t kPlenty = 200'000;
  std::vector<std::vector<double>> cosines(d.vehicles.size());
  for (const Trajectory& t : solution.trajectories)
    for (std::size_t i = 0; i < t.arrivals.size(); i += t.arrivals.size() / kPlenty + 1) {
      const ArrivalObservation& a = t.arrivals[i];
      const DeploymentReceiver& receiver = d.receivers[a.receiver.index()];
      if (a.rejection != Rejection::kUsed || !receiver.axis || !t.nodes[a.node].placed) continue;
      const Pose T = pose_at(t, a.node, a.alpha);
      const Eigen::Vector2d towards =
          (d.beacons[a.beacon.index()].position_m - T * receiver.position_m).head<2>();
      const Eigen::Vector2d axis = (T.rotation * *receiver.axis).head<2>();
      const double scale = towards.norm() * axis.norm();
      if (scale > 0) cosines[t.vehicle.index()].push_back(towards.dot(axis) / scale);
    }
  for (DeploymentReceiver& receiver : d.receivers) {
    std::vector<double>& seen = cosines[receiver.vehicle.index()];
    if (!receiver.axis || seen.size() < kEnough) continue;
    const auto outliers = static_cast<std::size_t>(kOutliers * static_cast<double>(seen.size()));
    receiver.hearing_cosine = nth_smallest(seen, outliers) - kMargin;
  }
}

void add_validity(const Problem& problem, const Solution& solution, Deployment& d) {
  LogExtent extent;
  if (solution.totals) {  // the trajectories are a part of the log
    extent = solution.totals->extent;
  } else {
    for (const Trajectory& t : solution.trajectories)
      extent.include(extent_of(t, problem.runs[t.run], problem.site));
  }
  if (extent.coldest_degC <= extent.hottest_degC && problem.site.medium.model != MediumModel::kConstant)
    d.validity_temperature_degC = {extent.coldest_degC, extent.hottest_degC};
  set_valid_space(std::move(extent), d);
  d.validity_reach_m = heard_reach_m(solution.trajectories, d.beacons);
}

/// White and correlated parts of the noise; how long a vehicle that moves as in the log stays in a cell of
/// the error model.
void add_noise(const Problem& problem, const Solution& solution, Deployment& d) {
  const ErrorModel& errors = solution.errors;
  d.noise.tof_sigma_s = solution.tof_sigma_s;
  if (!errors.correlated) return;
  // White noise and errors with a short correlation time are hard to distinguish. The least white share keeps
  // localizers from treating arrivals as exact.
  constexpr double kLeastWhite = 0.1;
  const double total =
      errors.white_tof + std::pow(errors.correlated_sigma(), 2) + std::pow(errors.pair_sigma(), 2);
  d.noise.tof_sigma_s *= std::sqrt(std::max(errors.white_tof, kLeastWhite * total));
  double path_m = 0.0, time_s = 0.0;
  for (const Trajectory& t : solution.trajectories) {
    auto segment = t.segments.begin();
    for (std::size_t k = 1; k < t.nodes.size(); ++k) {
      while (segment != t.segments.end() && segment->last_node <= k) ++segment;
      const bool is_gap =
          solution.totals && t.moving && segment != t.segments.end() && segment->first_node == k;
      if (!t.nodes[k - 1].placed || !t.nodes[k].placed || is_gap ||
          !(t.nodes[k].time_s > t.nodes[k - 1].time_s))
        continue;
      path_m += (t.nodes[k].T_map_vehicle.translation_m - t.nodes[k - 1].T_map_vehicle.translation_m).norm();
      time_s += t.nodes[k].time_s - t.nodes[k - 1].time_s;
    }
  }
  d.correlated_noise = {
      solution.tof_sigma_s * errors.correlated_sigma(),
      errors.correlation_time_s(time_s > 0 ? path_m / time_s : 0.0, problem.typical_range_m),
      solution.tof_sigma_s * errors.pair_sigma()};
}

}  // namespace

Deployment deployment_head(const Site& site, const Solution& solution, const Provenance& provenance) {
  Deployment d;
  d.site = site.name;
  d.created = provenance.created;
  d.motion = site.motion;
  d.medium = site.medium;
  d.timing = site.timing;
  d.noise = site.noise;
  d.tolerance = site.tolerance;
  d.validity_period = site.validity;
  d.drift = site.drift;
  d.datum = solution.datum;
  d.statistics = solution.statistics;
  d.inputs = provenance.inputs;
  d.program_version = provenance.version;
  d.program_command = provenance.command;
  d.contradictions = solution.contradictions;
  return d;
}

Deployment make_deployment(const Problem& problem, const Solution& solution, const Provenance& provenance) {
  const Variances variances(solution);
  Deployment d = deployment_head(problem.site, solution, provenance);
  const auto& offsets = solution.state.speed_offset_mps;
  // If each run has an offset, that of the last run is the most recent one.
  d.speed_offset_mps = offsets.back();
  d.speed_sigma_mps = variances.sigma(parameters::speed(offsets.size() > 1 ? offsets.size() : 0));
  add_noise(problem, solution, d);
  d.attenuation = solution.state.attenuation;
  d.covariance = solution.covariance;
  d.warnings = solution.warnings;
  add_beacons(problem, solution, variances, d);
  add_receivers(problem, solution, variances, d);
  add_hearing(solution, d);
  add_validity(problem, solution, d);
  return d;
}

}  // namespace octant::calib
