// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/drive_uncertainty.h"

#include <algorithm>
#include <set>
#include <vector>

#include "models/localizers/chain/chain_calibration.h"
#include "models/localizers/chain/chain_protection.h"
#include "models/localizers/common/separation.h"
#include "models/localizers/drive/motion_velocity.h"

namespace octant {
namespace {

/// Velocity at an instant of a trajectory with a motion prior, whose states contain it in the map.
VelocityEstimate prior_velocity_at(const Trajectory& t, const ChainWindow& window,
                                   const DriveInstant& instant, const Pose& T_map_vehicle) {
  const Node& node = t.nodes[instant.node];
  Eigen::Vector3d mean = node.velocity;
  if (instant.alpha > 0.0) mean += instant.alpha * (t.nodes[instant.node + 1].velocity - node.velocity);
  Eigen::Matrix3d R_vehicle_map = Eigen::Matrix3d::Identity();
  R_vehicle_map.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-T_map_vehicle.heading_rad()).toRotationMatrix();
  const Eigen::Matrix3d covariance = window.covariance_at(instant, 6).bottomRightCorner<3, 3>();
  const Eigen::Vector3d v = R_vehicle_map * mean,
                        variance = (R_vehicle_map * covariance * R_vehicle_map.transpose()).diagonal();
  return {in_space<3>(v), in_space<3>(variance)};
}

}  // namespace

void set_uncertainty(const Trajectory& t, const Segment& segment, const EpochFixModel& model,
                     const CalibrationPart& calibration, const DriveUncertaintyOptions& options,
                     std::span<const DriveInstant> instants, std::span<Fix> fixes) {
  const int dof = pose_dof(t.motion);
  const CalibrationErrors errors(t, segment, model.state.receiver_p_vehicle_m.size(), calibration,
                                 model.correlated.pair_sigma_s);
  std::vector<double> widened(instants.size());
  std::vector<ChainVariant> variants;
  variants.push_back(
      {BeaconId(), errors.columns(),
       [&errors](const ObservationRow& row, Eigen::RowVectorXd& e) { return errors.of(row, e); },
       [&](const ChainWindow& window) {
         for_each_instant(window, instants, [&](std::size_t i) {
           const PoseCovariance noise = window.covariance_at(instants[i], dof);
           const ChainWindow::Matrix x = window.solution_at(instants[i], dof);
           fixes[i].covariance = noise + x * x.transpose();
           if (t.motion_prior)
             fixes[i].velocity = prior_velocity_at(t, window, instants[i], fixes[i].T_map_vehicle);
           widened[i] = std::max(1.0, horizontal_variance(fixes[i].covariance) / horizontal_variance(noise));
         });
       }});
  DriveSeparation separation(instants, widened, dof);
  if (options.protect) {
    std::set<BeaconId> beacons;
    for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i)
      if (t.arrivals[i].rejection == Rejection::kUsed) beacons.insert(t.arrivals[i].beacon);
    for (const BeaconId beacon : beacons) variants.push_back(separation.without(beacon));
  }
  const std::vector<bool> determined = solve_by_windows(t, segment, model.state, variants, options.threads);
  // A drive that is lost without one of its beacons has no bound anywhere.
  const bool is_protected = variants.size() > 1 && std::ranges::find(determined, false) == determined.end();
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    if (!determined.front()) fixes[i].status = FixStatus::kPoorGeometry;
    if (is_protected)
      fixes[i].protection_level_m = separation.level_m(i, horizontal_variance(fixes[i].covariance));
  }
}

}  // namespace octant
