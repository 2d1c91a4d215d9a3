// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to the track of a vehicle in space: choice between mirror images.

#include <vector>

#include "models/localizers/space/space_filter.h"

namespace octant {

/// Returns true if a position may be in the plane or beyond it.
[[nodiscard]] bool is_near(const BeaconPlane& plane, const SpaceBelief& belief, double sigmas);

/// Returns true if the mirror image of a position is within the space for which the deployment is calibrated,
/// and the heights of the beacons do not exclude it.
[[nodiscard]] bool is_mirror_image_possible(const Eigen::Vector3d& p_map_m, const SpaceSetting& setting);

/// Log prior of a track: positions within the space for which the deployment is calibrated are likelier.
[[nodiscard]] double log_prior(const std::vector<SpaceStep>& steps, const SpaceSetting& setting);

/// Chooses the sides of a track relative to the plane of coplanar beacons, at which every position has a
/// mirror image. A filter keeps the side that it finds first, and its noise decides whether it passes through
/// the plane or is reflected. Here each piece of a track between two possible passages is compared with its
/// mirror image, with four likelihoods for each passage, and the most likely sequence of sides is found
/// (Viterbi 1967). The cost is linear in the length of the track. Motion determines which pieces are on the
/// same side. Which side that is follows from beacons off the plane, if the calibration knows their
/// deviations, and from the calibrated space; otherwise most of the track stays where it is.
/// @param first  instant at which the track begins
/// @param steps  smoothed steps of the track
/// @return steps to linearise at, with pieces reflected; empty if no other sequence is more likely
[[nodiscard]] std::vector<SpaceStep> likeliest_sides(SpaceRanges& ranges, const SpaceSetting& setting,
                                                     std::size_t first, const std::vector<SpaceStep>& steps,
                                                     double density);

}  // namespace octant
