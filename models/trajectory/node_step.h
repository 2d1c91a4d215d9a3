// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/physics/pose.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Moves a state by a step in its unknowns (Trajectory::block_size() of them): pose in its own frame, then
/// cycle offset [m, at the medium's nominal speed] or velocity.
/// @param like  a trajectory with states of the same kind
template <class Step>
void step_node(const Trajectory& like, const Step& step, Node& node) {
  const int dof = pose_dof(like.motion);
  node.T_map_vehicle = retract(node.T_map_vehicle, step.head(dof), like.motion);
  if (like.has_cycle_offset) node.cycle_offset_s += step[dof] / like.nominal_speed_mps;
  if (like.motion_prior) node.velocity += step.template tail<3>();
}

}  // namespace octant
