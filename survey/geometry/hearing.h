// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/physics/pose.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

/// Returns true if range, threshold and both directional patterns let a receiver receive a beacon, without
/// regard to walls.
/// @param unit  from the beacon to the receiver
/// @param receiver_axis  in the map
[[nodiscard]] bool loud_enough(const SurveyModel& model, std::size_t beacon, std::size_t receiver,
                               const Eigen::Vector3d& unit, double distance_m,
                               const Eigen::Vector3d& receiver_axis);

/// Returns true if one receiver receives one beacon: range, threshold, both patterns, and no obstacle between
/// them. For one path at a time; heard_at() (geometry_map.h) evaluates many poses.
[[nodiscard]] bool hears(const SurveyModel& model, std::size_t beacon, std::size_t receiver,
                         const Pose& T_map_vehicle);

}  // namespace octant::survey
