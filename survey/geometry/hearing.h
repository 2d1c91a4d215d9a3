// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/physics/pose.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

/// Whether the reach, the threshold and both patterns let a receiver hear a beacon, walls left aside.
/// @param unit  from the beacon to the receiver  @param receiver_axis  in the map
[[nodiscard]] bool loud_enough(const SurveyModel& model, std::size_t beacon, std::size_t receiver,
                               const Eigen::Vector3d& unit, double distance_m,
                               const Eigen::Vector3d& receiver_axis);

/// Whether one receiver hears one beacon: range, threshold, both patterns, and nothing that stops sound
/// between them. One path at a time; for many poses there is heard_at() (geometry_map.h).
[[nodiscard]] bool hears(const SurveyModel& model, std::size_t beacon, std::size_t receiver,
                         const Pose& T_map_vehicle);

}  // namespace octant::survey
