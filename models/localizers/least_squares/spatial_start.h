// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Geometry>

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/least_squares/search_problem.h"

namespace octant {

/// Initial positions: one, or one on each side of the beacons' plane.
struct LinearPositions {
  std::array<Eigen::Vector3d, 2> p_map_m;
  std::size_t count = 0;
};
/// Linear multilateration: |p - b|^2 = (range - o)^2, with one equation subtracted from the others, is linear
/// in p (and o) if lever arms are neglected. For coplanar beacons the distance from the plane is undetermined
/// in the minimum-norm solution, and both sides are returned. Normal equations suffice, since an initial
/// value needs half the digits.
[[nodiscard]] LinearPositions linear_positions(const SearchProblem& problem);

/// Rotations of the cube: every rotation is within 63 degrees of one of them, most within 45.
inline constexpr std::size_t kCoarseRotations = 24;
[[nodiscard]] std::array<Eigen::Quaterniond, kCoarseRotations> coarse_rotations();

/// Returns true if two poses differ by more than a distance or a tenth of a radian.
[[nodiscard]] bool differs(const Pose& a, const Pose& b, double distance_m);

/// Initial pose of a spatial fix (six degrees of freedom): position by linear multilateration without lever
/// arms, combined with a coarse set of rotations, each solved under a one-sided loss. Sets the node to the
/// best solution; found is false if there are too few arrivals. Returns true if a distinct second pose is
/// equally good.
[[nodiscard]] bool start_spatial(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                                 const EpochFixOptions& options, bool& found);

/// Initial position (and offset) of a fix in space without attitude: linear multilateration of small samples
/// of the beacons, each solved under a one-sided loss; the best by its cost. Sets the node, with the identity
/// as rotation. Results as those of start_spatial.
[[nodiscard]] bool start_place(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                               const EpochFixOptions& options, bool& found);

}  // namespace octant
