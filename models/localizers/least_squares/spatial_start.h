// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Geometry>

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/localizers/least_squares/search_problem.h"

namespace octant {

/// Positions to begin from; one, or one on either side of the beacons' plane.
struct LinearPositions {
  std::array<Eigen::Vector3d, 2> p_map_m;
  std::size_t count = 0;
};
/// |p - b|^2 = (range - o)^2, one equation subtracted from the others: linear in p (and o), lever arms
/// neglected. Beacons in a plane leave the distance from it open, which the minimum norm about their centre
/// sets to zero; both sides are told. By normal equations: a start needs half the digits.
[[nodiscard]] LinearPositions linear_positions(const SearchProblem& problem);

/// The rotations of the cube: none is further than 63 degrees away, most are within 45.
inline constexpr std::size_t kCoarseRotations = 24;
[[nodiscard]] std::array<Eigen::Quaterniond, kCoarseRotations> coarse_rotations();

/// By more than a distance, or a tenth of a radian.
[[nodiscard]] bool differs(const Pose& a, const Pose& b, double distance_m);

/// Start of a spatial fix (6 degrees of freedom): the origin by linear multilateration with the lever arms
/// neglected, a coarse set of rotations, each solved under a one-sided loss; the best by its cost. Sets the
/// node; found is false where the arrivals are too few. Returns whether a distinct second pose is as good.
[[nodiscard]] bool start_spatial(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                                 const EpochFixOptions& options, bool& found);

/// Start of a fix in space of which only the place (and the offset) is sought: linear multilateration of
/// small samples of the beacons, each solved under a one-sided loss; the best by its cost. Sets the node, its
/// rotation to the identity. Results as those of start_spatial.
[[nodiscard]] bool start_place(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                               const EpochFixOptions& options, bool& found);

}  // namespace octant
