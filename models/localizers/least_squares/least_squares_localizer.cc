// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "models/localizers/common/arrival_rejections.h"
#include "models/localizers/common/correlated_arrivals.h"
#include "models/localizers/common/open_attitude.h"
#include "models/localizers/common/protection.h"
#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/least_squares/node_adjustment.h"
#include "models/localizers/least_squares/place_fix.h"
#include "models/trajectory/make_trajectory.h"

namespace octant {
namespace {

using Matrix5d = Eigen::Matrix<double, 5, 5>;

constexpr std::size_t kScratchBytes =
    1u << 20;  ///< the search for sixteen beacons and eight receivers needs a quarter of it
constexpr std::size_t kRowsEachPair = 2;  ///< an epoch may contain several pings

/// Covariance of x, y, z, delay and speed, which affect a beacon's arrivals.
Matrix5d covariance_of(const Deployment& deployment, const ParameterIndex& row_of, std::size_t b) {
  const DeploymentBeacon& beacon = deployment.beacons[b];
  Matrix5d C = Matrix5d::Zero();
  const JointCovariance& joint = deployment.covariance;
  if (joint.matrix.rows() > 0 && joint.matrix.rows() == static_cast<Eigen::Index>(joint.parameters.size())) {
    const std::array<int, 4> own = row_of.beacon(b);
    const std::array<int, 5> rows = {own[0], own[1], own[2], own[3], row_of[parameters::speed()]};
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j)
        if (rows[static_cast<std::size_t>(i)] >= 0 && rows[static_cast<std::size_t>(j)] >= 0)
          C(i, j) = joint.matrix(rows[static_cast<std::size_t>(i)], rows[static_cast<std::size_t>(j)]);
    return C;
  }
  C.topLeftCorner<3, 3>() = beacon.covariance_m2;
  C(3, 3) = beacon.delay_sigma_s * beacon.delay_sigma_s;
  C(4, 4) = deployment.speed_sigma_mps * deployment.speed_sigma_mps;
  return C;
}

}  // namespace

TrajectoryModel trajectory_model(const Deployment& deployment) {
  TrajectoryModel model;
  model.motion = deployment.motion;
  model.medium = deployment.medium;
  model.timing = deployment.timing;
  model.noise = deployment.noise;
  model.noise.tof_sigma_s = single_arrival_sigma_s(deployment);
  model.attenuation = deployment.attenuation;
  for (const SiteVehicle& vehicle : deployment.vehicles) model.motion_priors.push_back(vehicle.motion);
  return model;
}

EpochFixModel epoch_fix_model(const Deployment& deployment) {
  EpochFixModel model;
  model.state = shared_state(deployment);
  const ParameterIndex row_of(deployment.covariance.parameters);
  for (std::size_t b = 0; b < deployment.beacons.size(); ++b) {
    model.beacon_usable.push_back(deployment.beacons[b].status != BeaconStatus::kUndetermined);
    model.beacon_covariance.push_back(covariance_of(deployment, row_of, b));
  }
  for (const DeploymentReceiver& receiver : deployment.receivers) {
    model.receiver_axis.push_back(receiver.axis);
    model.hearing_cosine.push_back(receiver.hearing_cosine.value_or(kHearingCosine));
  }
  model.correlated = correlated_noise(deployment);
  model.nominal_speed_mps = deployment.speed_mps(deployment.medium.temperature_degC);
  return model;
}

std::shared_ptr<const PlaceModel> place_model(const Deployment& deployment, const EpochFixModel& model) {
  auto place = std::make_shared<PlaceModel>();
  place->model = model;
  for (std::size_t v = 0; v < deployment.vehicles.size(); ++v)
    place->p_centre_vehicle_m.push_back(receiver_centre_m(deployment, VehicleId(v)));
  for (const DeploymentReceiver& r : deployment.receivers)
    place->receiver_variance_m2.push_back(
        open_attitude_variance_m2(r.position_m - place->p_centre_vehicle_m[r.vehicle.index()]));
  for (Eigen::Vector3d& p : place->model.state.receiver_p_vehicle_m) p.setZero();
  for (auto& axis : place->model.receiver_axis) axis.reset();
  place->model.state.receiver_axis.clear();
  return place;
}

void leave_attitude_open(const PlaceModel& place, Fix& fix) {
  if (!fix.ok() || !fix.vehicle.valid() || fix.vehicle.index() >= place.p_centre_vehicle_m.size()) return;
  const Eigen::Vector3d& p_centre_m = place.p_centre_vehicle_m[fix.vehicle.index()];
  fix.covariance.rightCols<3>().setZero();
  fix.covariance.bottomRows<3>().setZero();
  fix.covariance.diagonal().head<3>().array() += open_attitude_variance_m2(p_centre_m);
  fix.covariance.diagonal().tail<3>().setConstant(kUnknownRotationVariance);
  if (fix.protection_level_m > 0.0) fix.protection_level_m += p_centre_m.norm();
}

LeastSquaresLocalizer::LeastSquaresLocalizer(Deployment deployment, EpochFixOptions options)
    : Localizer(deployment),
      deployment_(std::move(deployment)),
      options_(options),
      model_(epoch_fix_model(deployment_)),
      calibration_(deployment_),
      trajectory_model_(trajectory_model(deployment_)),
      scratch_(kScratchBytes) {
  options_.closed_form_first = true;
  if (deployment_.motion == Motion::kSpatial) place_ = place_model(deployment_, model_);
  const std::size_t arrivals =
      kRowsEachPair * deployment_.beacons.size() * std::max<std::size_t>(deployment_.receivers.size(), 1);
  reserve_epoch(epoch_, arrivals, kRowsEachPair * deployment_.beacons.size());
}

/// Repeats the fix with the arrivals that are in use now; false if there is no fix.
bool LeastSquaresLocalizer::adjust_again(Trajectory& trajectory, const Segment& epoch,
                                         const EpochFixModel& model, Fix& fix) const {
  report_arrivals(trajectory, epoch.first_arrival, epoch.last_arrival, fix);
  const NodeAdjustment adjustment = adjust_node(trajectory, epoch, model.state, options_.range_uncertainty_m);
  fix.T_map_vehicle = trajectory.nodes[epoch.first_node].T_map_vehicle;
  fix.cost = adjustment.cost;
  if (!adjustment.converged || !pose_covariance(trajectory, adjustment.information, fix.covariance))
    return false;
  calibration_.add_to(fix.covariance, trajectory, epoch, model.state);
  return true;
}

void LeastSquaresLocalizer::fix_segment(Trajectory& trajectory, const Segment& epoch, Fix& fix) const {
  const EpochFixModel* model = &model_;
  if (place_) {
    model = &fix_pose_or_place(trajectory, epoch, model_, *place_, options_, fix);
  } else {
    fix_epoch(trajectory, epoch, model_, options_, fix);
  }
  if (fix.ok()) calibration_.add_to(fix.covariance, trajectory, epoch, model->state);
  // Misfits of roughly known beacons are not faults.
  if (fix.ok() && options_.range_uncertainty_m == 0.0) protect(trajectory, epoch, *model, fix);
  if (model != &model_) leave_attitude_open(*place_, fix);
}

/// Bounds the error of a fix under one fault. A beacon whose arrivals together contradict the others is
/// excluded if three others remain, which must then agree; with two, the faulty one cannot be identified.
/// Without agreement all remain in use, and the fix has no level.
void LeastSquaresLocalizer::protect(Trajectory& trajectory, const Segment& epoch, const EpochFixModel& model,
                                    Fix& fix) const {
  constexpr int kMostExcluded = 2, kFewestBeacons = 4;
  const BeaconErrors errors{model.beacon_covariance,
                            std::hypot(model.correlated.sigma_s, model.correlated.pair_sigma_s)};
  bool made = true;
  for (int excluded = 0; made; ++excluded) {
    const Protection protection = protection_of(trajectory, epoch, model.state, fix.covariance, errors);
    fix.protection_level_m = protection.level_m;
    if (!protection.at_fault.valid()) return;
    if (!options_.exclude_faulty_beacons || excluded == kMostExcluded || protection.beacons < kFewestBeacons)
      break;
    set_rejections(trajectory, epoch, protection.at_fault, Rejection::kUsed, Rejection::kBeaconFault);
    made = adjust_again(trajectory, epoch, model, fix);
  }
  if (set_rejections(trajectory, epoch, BeaconId(), Rejection::kBeaconFault, Rejection::kUsed) &&
      !adjust_again(trajectory, epoch, model, fix))
    fix.status = FixStatus::kNoConsensus;
  fix.protection_level_m = 0.0;
}

void LeastSquaresLocalizer::locate_known(const Observations& observations, Fix& fix) noexcept {
  clear(fix);
  if (observations.arrivals.empty() && observations.bearings.empty()) return;
  const ScratchScope scope(scratch_);
  set_epoch(epoch_, observations.arrivals, observations.bearings, trajectory_model_);
  fix_segment(epoch_, epoch_.segments.front(), fix);
}

std::vector<Fix> LeastSquaresLocalizer::locate(const MeasurementLog& all_rows) {
  std::vector<Fix> fixes;
  MeasurementLog room;
  const MeasurementLog& log = known_rows(all_rows, deployment_, room);
  for (std::size_t v = 0; v < deployment_.vehicles.size(); ++v) {
    Trajectory trajectory = make_trajectory(log, 0, VehicleId(v), trajectory_model_);
    for (const Segment& segment : trajectory.segments)
      for (std::size_t node = segment.first_node; node < segment.last_node; ++node) {
        const ScratchScope scope(scratch_);
        const Segment epoch = node_segment(trajectory, segment, node);
        fix_segment(trajectory, epoch, fixes.emplace_back());
      }
  }
  std::ranges::stable_sort(fixes, {}, &Fix::time_s);
  return fixes;
}

}  // namespace octant
