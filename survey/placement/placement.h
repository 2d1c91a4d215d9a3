// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "models/scene.h"
#include "models/support/result.h"
#include "survey/geometry/survey_model.h"
#include "survey/placement/placement_options.h"

namespace octant::survey {

struct PlacedBeacon {
  SurveyBeacon beacon;
  std::string mount;  ///< name of the scene's mount; empty: it was there already
};

struct Placement {
  std::vector<PlacedBeacon> beacons;       ///< kept ones first
  LayoutFigures figures, greedy, regular;  ///< over the final cells; regular: the best of eight phases
  LayoutFigures random;                    ///< the median of 25 layouts by their objective
  std::size_t evaluations = 0, cells = 0;
  bool interrupted = false;
};

/// Places the given number of beacons (kept ones included) on the mounts of the scene: greedy choice from a
/// grid of positions, exchanges on that grid until none improves the layout, then NLopt's global and local
/// algorithms on the mounts (S. G. Johnson, The NLopt nonlinear-optimization package). The result is the best
/// of all, so it is never worse than the greedy one. Deterministic for a seed. Errors: a scene without
/// mounts, fewer beacons than are kept, a floor without cells.
[[nodiscard]] Result<Placement> place_beacons(const SurveyModel& model, const Scene& scene,
                                              std::size_t beacons, const PlacementOptions& options);

/// The smallest number of beacons whose goal is within the tolerance and that covers every cell.
struct SmallestPlacement {
  bool reached = false;
  std::vector<std::pair<std::size_t, LayoutFigures>> tried;
  Placement placement;  ///< placement with the smallest sufficient number, or with the last number tried
};
[[nodiscard]] Result<SmallestPlacement> smallest_placement(const SurveyModel& model, const Scene& scene,
                                                           double tolerance_m, std::size_t most_beacons,
                                                           const PlacementOptions& options);

/// Quality of an existing layout, on the cells for which a placement states its figures.
[[nodiscard]] Result<LayoutFigures> layout_figures(const SurveyModel& model, const Scene& scene,
                                                   const PlacementOptions& options);

}  // namespace octant::survey
