// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/plan/station_information.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "calib/adjust/covariance.h"
#include "calib/adjust/information.h"
#include "calib/adjust/priors.h"
#include "calib/deployed_site.h"
#include "calib/problem/ranges.h"
#include "calib/problem/shared_entries.h"
#include "calib/verdict/datum.h"
#include "models/support/decompositions.h"
#include "models/support/unit_diagonal.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

/// Coordinates without a stated accuracy are known to the site's extent times this: vague, but not so vague
/// that rounding shows.
constexpr double kVagueExtents = 4.0;
/// Audible with so much in hand over the threshold: a crossing at the very threshold comes infinitely late.
constexpr double kAudible = 1.05;
constexpr double kSure = 2.0;        ///< sigmas of a beacon's position by which it must be within range
constexpr double kMostMargin = 0.1;  ///< largest margin of range and angle
constexpr double kUnobservableByStop = 1e-12;  ///< threshold for a covariance scaled to a unit diagonal
constexpr double kPoseRank =
    1e-9;  ///< relative to the largest of the rows; directions of the pose below it are unobservable

tl::unexpected<Error> bad(const std::string& file, std::string found, std::string expected,
                          std::string advice = {}) {
  return fail({.code = Errc::kBadInput,
               .file = file,
               .found = std::move(found),
               .expected = std::move(expected),
               .advice = std::move(advice)});
}

/// @param needs_places  there are no recordings from which they follow
Result<void> check(const Site& site, bool needs_places) {
  if (site.receivers.empty() || site.vehicles.empty())
    return bad(site.path, "no vehicle has receivers",
               "vehicles with receivers, which hear the beacons at a stop");
  if (!site.tof_sigma_given || !(site.noise.tof_sigma_s > 0))
    return bad(site.path, "the site does not say how accurate an arrival is", "noise.tof_sigma_s above zero");
  if (needs_places &&
      std::ranges::none_of(site.beacons, [](const SiteBeacon& b) { return b.place_m().has_value(); }))
    return bad(site.path, "no beacon has a position", "position_m of the beacons, approximate ones will do",
               "give approximate positions, or recordings from which they follow");
  return {};
}

double extent_of_placed_m(const Site& site, const std::vector<bool>& placed) {
  Eigen::AlignedBox3d box;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    if (placed[b]) box.extend(*site.beacons[b].place_m());
  return std::max(1.0, box.diagonal().norm());
}

/// Information of the priors only; parameters without a prior get a weak one.
Eigen::MatrixXd with_vague_priors(const Problem& problem, const ParameterLayout& layout,
                                  const SharedState& state, double vague_m) {
  Eigen::MatrixXd N = prior_information(problem, layout, layout.vector_of(state));
  for (int i = 0; i < layout.size(); ++i)
    if (!std::isfinite(layout.parameter(i).prior_sigma)) N(i, i) += 1.0 / (vague_m * vague_m);
  return N;
}

/// Inverse of a joint covariance within the directions that it varies in.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& C) {
  const UnitDiagonal<Eigen::MatrixXd> unit(C);
  const SymmetricEigen<Eigen::MatrixXd> eigen(unit.scaled);
  return unit.inverse(eigen.eigenvectors(), eigen.eigenvalues().unaryExpr([](double v) {
    return v > kUnobservableByStop ? 1.0 / v : 0.0;
  }));
}

/// The site that a deployment describes, its sigmas as priors, so that the parameters of its covariance are
/// free again.
Site site_with_priors(const Deployment& d) {
  const ParameterIndex column(d.covariance.parameters);
  const auto is_free = [&](const ParameterId& id) { return column[id] >= 0; };
  Site site = deployed_site(d);
  site.speed_sigma_mps = is_free(parameters::speed()) ? std::max(d.speed_sigma_mps, 1e-9) : 0.0;
  if (!(site.timing.delay_sigma_s > 0)) site.timing.delay_per = {};
  for (std::size_t i = 0; d.attenuation && i < kAttenuationUnknowns; ++i) {
    const double value = attenuation_unknown(*d.attenuation, i);
    attenuation_unknown(*site.attenuation, i) = {
        value, is_free(parameters::attenuation(i)) ? std::max(1e-6, std::abs(value)) : 0.0};
  }
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    for (std::size_t i = 0; i < 3 && d.beacons[b].status != BeaconStatus::kUndetermined; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      site.beacons[b].position_m[i] = d.beacons[b].position_m[k];
      site.beacons[b].sigma_m[i] = is_free(parameters::beacon_position(b, i))
                                       ? std::sqrt(std::max(1e-18, d.beacons[b].covariance_m2(k, k)))
                                       : 0.0;
    }
  for (std::size_t r = 0; r < d.receivers.size(); ++r)
    for (std::size_t i = 0; i < 3; ++i)
      if (const auto k = static_cast<Eigen::Index>(i); is_free(parameters::receiver_position(r, i)))
        site.receivers[r].sigma_m[k] = std::max(d.receivers[r].sigma_m[k], 1e-9);
  return site;
}

/// A joint covariance in SI units, where the layout has its columns.
Eigen::MatrixXd information_of(const JointCovariance& joint, const ParameterLayout& layout,
                               Eigen::MatrixXd information) {
  const ParameterIndex column(joint.parameters);
  std::vector<int> from, to;
  for (int i = 0; i < layout.size(); ++i) {
    const int at = column[layout.parameter(i).id];
    if (at < 0) continue;
    from.push_back(at);
    to.push_back(i);
  }
  const Eigen::VectorXd units_per_si = layout.si_per_unit()(to).cwiseInverse();
  information(to, Eigen::all).setZero();
  information(Eigen::all, to).setZero();
  information(to, to) =
      pseudo_inverse(units_per_si.asDiagonal() * joint.matrix(from, from) * units_per_si.asDiagonal());
  return information;
}

void fill_from_site(Knowledge& k, const SharedState& state) {
  const Site& site = k.problem.site;
  for (const SiteBeacon& b : site.beacons) {
    const bool has_place = b.place_m().has_value();
    k.placed.push_back(has_place);
    if (!has_place)
      k.warnings.push_back(
          fmt::format("beacon {} has no position: the plan leaves it out; give an approximate one, or a "
                      "recording that hears it",
                      b.name));
  }
  const double extent = extent_of_placed_m(site, k.placed);
  k.problem.typical_range_m = 0.5 * extent;
  k.problem.runs.resize(1);
  k.state = state;
  k.layout = make_layout(k.problem, k.state, k.placed);
  k.information = with_vague_priors(k.problem, k.layout, k.state, kVagueExtents * extent);
  k.tof_sigma_s = site.noise.tof_sigma_s;
}

bool hears(const Knowledge& k, std::size_t beacon, std::size_t receiver_index,
           const Eigen::Vector3d& p_receiver_map_m, const Pose& T_map_vehicle, const HearingModel& hearing) {
  const SiteReceiver& receiver = k.problem.site.receivers[receiver_index];
  const Eigen::Vector3d towards = k.state.beacon_p_map_m[beacon] - p_receiver_map_m;
  const double distance_m = towards.norm();
  if (distance_m < 1e-6) return false;
  const double margin_m =
      std::min(kSure * k.place_sigma_m[beacon], kMostMargin * std::min(hearing.range_m, distance_m));
  if (distance_m + margin_m > hearing.range_m) return false;
  if (const auto& model = k.state.attenuation) {
    const Eigen::Vector3d* axis = k.state.axis_of(ReceiverId(receiver_index));
    double gain = 1.0;
    if (axis != nullptr && !axis->isZero())
      gain = std::exp(log_directivity((T_map_vehicle.rotation * *axis).dot(towards) / distance_m,
                                      model->half_power_angle_rad)
                          .value);
    if (!(gain * amplitude_v(distance_m + margin_m, *model) > kAudible * model->threshold_v)) return false;
  }
  if (receiver.axis && hearing.half_angle_rad < M_PI &&
      (T_map_vehicle.rotation * receiver.axis->normalized()).dot(towards) <
          std::cos(hearing.half_angle_rad - margin_m / distance_m) * distance_m)
    return false;
  return !hearing.also || hearing.also(BeaconId(beacon), ReceiverId(receiver_index), T_map_vehicle);
}

/// From priors, or from a calibration, depending on the layout's columns.
void fill_place_sigmas(Knowledge& k) {
  const Eigen::MatrixXd C =
      *Covariance(k.information, free_datum(k.problem, k.layout, k.state, k.information)).matrix();
  for (const auto& beacon : k.layout.beacon) {
    double variance = 0.0;
    for (const int c : beacon)
      if (c >= 0) variance = std::max(variance, C(c, c));
    k.place_sigma_m.push_back(std::sqrt(variance));
  }
}

/// The stop as a trajectory of one state with every arrival that is expected there.
Trajectory stop_trajectory(const Knowledge& k, const Pose& T_map_vehicle, const StopModel& model,
                           StopRows& out) {
  const Site& site = k.problem.site;
  Trajectory t;
  t.vehicle = model.vehicle;
  t.motion = site.motion;
  t.has_cycle_offset = site.timing.clock == Clock::kCycleOffset;
  t.nominal_speed_mps = speed_mps(site.medium);
  t.turnaround_s = site.timing.turnaround_s;
  t.T_hear_send.emplace_back();
  t.nodes.push_back({.T_map_vehicle = T_map_vehicle, .placed = true});
  out.arrivals.assign(site.beacons.size(), 0);
  const SiteVehicle& vehicle = site.vehicles[model.vehicle.index()];
  const bool two_way = site.timing.ranging == Ranging::kTwoWay;
  for (std::size_t r = vehicle.first_receiver; r < vehicle.first_receiver + vehicle.receiver_count; ++r) {
    const Eigen::Vector3d p = T_map_vehicle * k.state.receiver_p_vehicle_m[r];
    for (std::size_t b = 0; b < site.beacons.size(); ++b) {
      if (!k.placed[b] || !hears(k, b, r, p, T_map_vehicle, model.hearing)) continue;
      t.arrivals.push_back({.beacon = BeaconId(b),
                            .receiver = ReceiverId(r),
                            .sigma_s = k.tof_sigma_s / std::sqrt(model.firings),
                            .model_speed_mps = t.nominal_speed_mps,
                            .two_way = two_way,
                            .hear_send = two_way ? 0 : -1});
      out.arrivals[b] += static_cast<std::size_t>(model.firings);
    }
  }
  out.arrival_count = t.arrivals.size() * static_cast<std::size_t>(model.firings);
  if (const auto& poses = model.measured_poses)
    t.poses.push_back(
        {.T_map_vehicle = T_map_vehicle,
         .position_sigma_m = std::max(poses->position_sigma_m, 1e-6),
         .heading_sigma_rad = poses->heading_known ? std::max(poses->heading_sigma_rad, 1e-6) : INFINITY,
         .attitude_sigma_rad = std::max(poses->attitude_sigma_rad, 1e-6)});
  t.segments.push_back({.last_node = 1, .last_arrival = t.arrivals.size(), .last_pose = t.poses.size()});
  return t;
}

/// Number of directions of a pose that move no receiver of the arrivals: turns about a single receiver, or
/// about the line through all of them in space. Ranges need not determine these.
int open_directions(const Trajectory& t, const SharedState& state) {
  const Eigen::Index dimensions = t.motion == Motion::kPlanar ? 2 : 3;
  if (t.arrivals.empty()) return 0;
  const auto place = [&](const ArrivalObservation& a) -> Eigen::VectorXd {
    return state.receiver_p_vehicle_m[a.receiver.index()].head(dimensions);
  };
  Eigen::MatrixXd apart(t.arrivals.size(), dimensions);
  for (std::size_t i = 0; i < t.arrivals.size(); ++i)
    apart.row(static_cast<Eigen::Index>(i)) = place(t.arrivals[i]) - place(t.arrivals.front());
  if (apart.isZero()) return t.motion == Motion::kPlanar ? 1 : 3;
  PivotedQr qr(apart);
  qr.setThreshold(kPoseRank);
  return t.motion == Motion::kSpatial && qr.rank() == 1 ? 1 : 0;
}

}  // namespace

Result<Knowledge> knowledge_of(const Site& site) {
  if (auto sound = check(site, true); !sound) return fail(sound.error());
  Knowledge k;
  k.problem.site = site;
  fill_from_site(k, prior_state(site));
  fill_place_sigmas(k);
  return k;
}

Result<Knowledge> knowledge_of(const Problem& problem, const Solution& solution, int threads) {
  if (auto sound = check(problem.site, false); !sound) return fail(sound.error());
  if (solution.beacon_status.empty())
    return bad(problem.site.path,
               "the recordings do not determine where the vehicle was: " + solution.message,
               "recordings that can be calibrated", "plan from the site file alone");
  Knowledge k;
  k.problem = without_recordings(problem);
  k.state = solution.state;
  k.tof_sigma_s = solution.tof_sigma_s > 0 ? solution.tof_sigma_s : problem.site.noise.tof_sigma_s;
  const auto& known =
      solution.covariance.parameters.empty() ? solution.marginals.parameters : solution.covariance.parameters;
  std::vector<bool> has_free(problem.site.beacons.size(), false);
  for (const ParameterId& id : known)
    if (const auto beacon = beacon_of(id)) has_free[*beacon] = true;
  for (std::size_t i = 0; i < problem.site.beacons.size(); ++i) {
    const SiteBeacon& b = problem.site.beacons[i];
    const bool found = b.is_control_point() || has_free[i];
    k.placed.push_back(found);
    if (!found) k.warnings.push_back(fmt::format("beacon {} was not found: the plan leaves it out", b.name));
  }
  k.layout = make_layout(problem, k.state, k.placed);
  std::vector<Trajectory> trajectories = solution.trajectories;
  const Information information =
      information_at(problem, k.layout, trajectories, k.layout.vector_of(k.state), {.threads = threads});
  k.information = information.data + information.prior;
  fill_place_sigmas(k);
  return k;
}

Result<Knowledge> knowledge_of(const Deployment& deployment) {
  if (deployment.covariance.parameters.empty())
    return bad("", "the deployment has no joint covariance", "a deployment that calibrate wrote",
               "plan from the site file");
  Knowledge k;
  k.problem.site = site_with_priors(deployment);
  if (auto sound = check(k.problem.site, true); !sound) return fail(sound.error());
  fill_from_site(k, shared_state(deployment));
  k.information = information_of(deployment.covariance, k.layout, std::move(k.information));
  fill_place_sigmas(k);
  return k;
}

HearingModel hearing_of(const Solution& solution, const Site& site) {
  constexpr double kShare = 0.995;
  std::vector<double> ranges_m, angles_rad;
  for (const Trajectory& t : solution.trajectories)
    for (const ArrivalObservation& a : t.arrivals) {
      if (a.rejection != Rejection::kUsed || !t.nodes[a.node].placed) continue;
      const Pose T = pose_at(t, a.node, a.alpha);
      const Eigen::Vector3d towards = solution.state.beacon_p_map_m[a.beacon.index()] -
                                      T * solution.state.receiver_p_vehicle_m[a.receiver.index()];
      ranges_m.push_back(towards.norm());
      if (const auto& axis = site.receivers[a.receiver.index()].axis)
        angles_rad.push_back(
            std::acos(std::clamp((T.rotation * axis->normalized()).dot(towards.normalized()), -1.0, 1.0)));
    }
  HearingModel hearing;
  if (!ranges_m.empty()) hearing.range_m = quantile(std::move(ranges_m), kShare);
  if (!angles_rad.empty()) hearing.half_angle_rad = quantile(std::move(angles_rad), kShare);
  return hearing;
}

StopRows stop_rows(const Knowledge& k, const Eigen::Vector2d& position_m, double heading_rad,
                   const StopModel& model) {
  StopRows out;
  Pose T = Pose::planar(position_m.x(), position_m.y(), heading_rad);
  if (k.problem.site.motion == Motion::kSpatial) T.translation_m.z() = model.height_m;
  const Trajectory t = stop_trajectory(k, T, model, out);
  // A new recording has the last offset of the speed where each has its own.
  const std::size_t run = k.layout.speed.empty() ? 0 : k.layout.speed.size() - 1;
  std::vector<RowEntries> entries;
  Eigen::MatrixXd Jx(2 * t.arrivals.size() + 6, t.block_size());
  std::vector<int> columns;
  for_each_row(t, t.segments[0], k.state, [&](const ObservationRow& row) {
    Jx.row(static_cast<Eigen::Index>(entries.size())) = row.by_node;
    entries.push_back(row_entries(row, run, k.layout, k.state));
    for (int i = 0; i < entries.back().count; ++i)
      columns.push_back(entries.back().column[static_cast<std::size_t>(i)]);
  });
  const auto rows = static_cast<Eigen::Index>(entries.size());
  if (rows == 0) return out;
  PivotedQr qr(Jx.topRows(rows));
  qr.setThreshold(kPoseRank);
  const auto determined = static_cast<Eigen::Index>(qr.rank());
  if (rows <= determined || determined < t.block_size() - open_directions(t, k.state)) return out;
  std::ranges::sort(columns);
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  Eigen::MatrixXd Js = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index r = 0; r < rows; ++r)
    for (int i = 0; i < entries[static_cast<std::size_t>(r)].count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const int column = entries[static_cast<std::size_t>(r)].column[at];
      Js(r, std::ranges::lower_bound(columns, column) - columns.begin()) +=
          entries[static_cast<std::size_t>(r)].value[at];
    }
  // Rows of Q' Js below those of the pose: the information that remains after its elimination.
  out.A = qr.transposed_times(std::move(Js)).bottomRows(rows - determined);
  out.columns = std::move(columns);
  return out;
}

void add_information(const StopRows& rows, Eigen::MatrixXd& information, double factor) {
  information(rows.columns, rows.columns) += factor * (rows.A.transpose() * rows.A);
}

}  // namespace octant::calib
