// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Model of a vehicle in space if only its position is estimated: all receivers are at their centre.
struct PlaceModel {
  EpochFixModel model;
  std::vector<Eigen::Vector3d> p_centre_vehicle_m;  ///< centre of each vehicle's receivers
  std::vector<double> receiver_variance_m2;  ///< variance of each receiver about the centre, in each axis
};
[[nodiscard]] std::shared_ptr<const PlaceModel> place_model(const Deployment& deployment,
                                                            const EpochFixModel& model);

/// Fix of a segment of one node in space: a pose (fix_epoch) if three receivers that are not collinear
/// received enough for it; otherwise the position of the receivers' centre, a fix with three unknowns, from
/// three or more beacons. Returns the model of the fix: `model`, or that of `place`. For the latter, call
/// leave_attitude_open() after everything else is added to the fix.
const EpochFixModel& fix_pose_or_place(Trajectory& trajectory, const Segment& segment,
                                       const EpochFixModel& model, const PlaceModel& place,
                                       const EpochFixOptions& options, Fix& fix);

/// Completes a fix of a position: its rotation is unknown, and the possible distance of the origin from the
/// centre is part of covariance and protection level (open_attitude.h).
void leave_attitude_open(const PlaceModel& place, Fix& fix);

}  // namespace octant
