// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/protection.h"

#include <algorithm>
#include <cmath>

#include "models/trajectory/linearise.h"
#include "models/trajectory/planar.h"

namespace octant {
namespace {

using ByCalibration = Eigen::Matrix<double, 1, 5>;  ///< x, y, z and delay of the beacon; speed

double common_variance(BeaconId beacon, const ByCalibration& by, const BeaconErrors& errors) {
  double common = std::pow(by[3] * errors.common_sigma_s, 2);
  if (beacon.index() < errors.calibration.size())
    common += std::max(0.0, by.dot(errors.calibration[beacon.index()] * by.transpose()));
  return common;
}

void add_planar_rows(const Trajectory& t, const Segment& segment, const SharedState& state,
                     const BeaconErrors& errors, BeaconSums& sums) {
  const PlanarNode at(t.nodes[segment.first_node].T_map_vehicle);
  ArrivalWhitening whitening(state.speed_offset(t.run));
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (a.rejection != Rejection::kUsed) continue;
    whitening.set(a);
    const PlanarArrival row(a, at, state, whitening);
    const Eigen::RowVector3d by(row.by_x(), row.by_y(), row.by_heading);
    ByCalibration by_calibration;
    by_calibration << -row.by_distance * row.direction[0], -row.by_distance * row.direction[1],
        -row.by_distance * row.direction[2], whitening.by_tof,
        -row.by_distance * row.distance_m * whitening.slowness;
    sums.add(a.beacon, by, row.residual, common_variance(a.beacon, by_calibration, errors));
  }
}

/// Sums over all rows, and over those of each beacon.
BeaconSums sums_of(const Trajectory& t, const Segment& segment, const SharedState& state,
                   const BeaconErrors& errors) {
  BeaconSums sums(t.block_size());
  Segment rows = segment;
  if (t.block_size() == 3 && segment.last_node - segment.first_node == 1 &&
      has_planar_arrivals(t, segment, state)) {
    add_planar_rows(t, segment, state, errors, sums);
    rows.first_arrival = rows.last_arrival;
  }
  for_each_row(t, rows, state, [&](const ObservationRow& row) {
    if (row.kind != RowKind::kTof) return sums.add(row.by_node, row.residual);
    ByCalibration by;
    by << row.by_beacon, row.by(kByDelay), row.by(kBySpeed);
    sums.add(row.beacon, row.by_node, row.residual, common_variance(row.beacon, by, errors));
  });
  // An undetermined rotation gets the variance of an unknown angle and does not affect the position.
  for (int i = first_turn(t.motion); i < pose_dof(t.motion); ++i) sums.add_information(i, kVagueAngle);
  return sums;
}

}  // namespace

std::pmr::vector<BeaconSeparation> separations(const Trajectory& t, const Segment& segment,
                                               const SharedState& state, const BeaconErrors& errors) {
  return sums_of(t, segment, state, errors).separations();
}

Protection protection_of(const Trajectory& t, const Segment& segment, const SharedState& state,
                         const PoseCovariance& covariance, const BeaconErrors& errors) {
  return sums_of(t, segment, state, errors).protection(horizontal_variance(covariance));
}

}  // namespace octant
