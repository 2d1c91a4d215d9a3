// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "survey/geometry/geometry_figures.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

/// Information of a beacon on the unknowns at each pose, weighted by the noise of the ranges: the packed
/// upper triangle, entry by entry (entry e of pose i at e * poses + i). Layers of several beacons add up.
struct BeaconLayer {
  std::vector<double> information;
  std::vector<std::uint8_t> heard;  ///< 1: received by at least one receiver
};

struct MapOptions {
  int threads = 1;
  bool integrity = true;  ///< detectable biases and protection levels
};

/// Dilutions, sigmas and integrity at each pose, in vector lanes and threads.
[[nodiscard]] GeometryFigures evaluate_poses(const SurveyModel& model, const PoseList& poses,
                                             const MapOptions& options = {});

/// Audibility: one row of poses for each beacon, 1 if at least one receiver receives it.
[[nodiscard]] std::vector<std::vector<std::uint8_t>> heard_at(const SurveyModel& model, const PoseList& poses,
                                                              int threads = 1);

/// Information layers, for searches over many sets of beacons at the same poses: a layer for each candidate
/// once, then sums.
/// @param beacon  any beacon, of the model or not; walls, receivers, hearing and noise are those of the model
[[nodiscard]] BeaconLayer beacon_layer(const SurveyModel& model, const SurveyBeacon& beacon,
                                       const PoseList& poses, int threads = 1);

/// Expected horizontal standard deviation at each pose [m] for the sum of the layers' information (stored as
/// BeaconLayer::information); kNoFix where no fix is possible. Allocates no memory.
void sigma_of_information(const Unknowns& unknowns, std::span<const double> information,
                          std::span<double> sigma_m);

}  // namespace octant::survey
