// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to the track of a vehicle in space.

#include <vector>

#include "models/localizers/space/space_filter.h"

namespace octant {

/// Whether a place may as well be in the plane, or beyond it.
[[nodiscard]] bool is_near(const BeaconPlane& plane, const SpaceBelief& belief, double sigmas);

/// Beacons in one plane leave a mirror image of every place. A filter keeps the side that it comes upon first
/// and goes through the plane, or is thrown back from it, as its noise has it. Here each piece of a track
/// between two passages is held against its mirror image together with its neighbours, four likelihoods a
/// passage, and of all sequences of sides the likeliest is taken (Viterbi 1967); linear in the length of the
/// track. Motion tells which pieces are on one side. Which side that is, beacons off the plane tell where the
/// calibration knows by how much; else most of the track stays where it is.
/// @param first  instant where the track begins
/// @param steps  of the track, smoothed
/// @return steps to linearise at, pieces reflected; empty where nothing is likelier than what is
[[nodiscard]] std::vector<SpaceStep> likeliest_sides(SpaceRanges& ranges, const SpaceSetting& setting,
                                                     std::size_t first, const std::vector<SpaceStep>& steps,
                                                     double density);

}  // namespace octant
