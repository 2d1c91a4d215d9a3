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

/// A vehicle in space of which only the place is sought: all its receivers are in one point, their centre.
struct PlaceModel {
  EpochFixModel model;
  std::vector<Eigen::Vector3d> p_centre_vehicle_m;  ///< of each vehicle's receivers
  std::vector<double> receiver_variance_m2;  ///< of each receiver's place about the centre, in each axis
};
[[nodiscard]] std::shared_ptr<const PlaceModel> place_model(const Deployment& deployment,
                                                            const EpochFixModel& model);

/// Fix of a segment of one node in space: a pose (fix_epoch) where three receivers that are not in line
/// received enough for it; else the place of the receivers' centre, a fix of three unknowns, from three
/// beacons on. Returns the model that the fix was made by: `model`, or that of `place`. For the latter
/// leave_attitude_open() is to be called when all else is added to the fix.
const EpochFixModel& fix_pose_or_place(Trajectory& trajectory, const Segment& segment,
                                       const EpochFixModel& model, const PlaceModel& place,
                                       const EpochFixOptions& options, Fix& fix);

/// Completes a fix of a place: its rotation is unknown, and what that may put the origin off the centre
/// counts in covariance and protection level (open_attitude.h).
void leave_attitude_open(const PlaceModel& place, Fix& fix);

}  // namespace octant
