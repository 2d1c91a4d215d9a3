// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: from a model and poses to what map_kernel.h takes.

#include <cstddef>
#include <vector>

#include "survey/geometry/geometry_figures.h"
#include "survey/geometry/kernel_tile.h"
#include "survey/geometry/survey_model.h"

namespace octant::survey {

[[nodiscard]] KernelModel kernel_model(const SurveyModel& model, const std::vector<SurveyBeacon>& beacons);

/// Fills a tile with poses [first, first + count) and the walls that may matter to them. A wall is left out
/// where it cannot stand between any of them and the beacon; a beacon is skipped where it is out of reach of
/// all, or one wall hides it from all.
void fill_tile(const KernelModel& kernel, const std::vector<WallPiece>& walls, const PoseList& poses,
               std::size_t first, std::size_t count, KernelTile& tile);

}  // namespace octant::survey
