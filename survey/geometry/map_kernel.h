// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: the vector lanes under geometry_map.h.

#include <cstddef>

#include "survey/geometry/kernel_tile.h"

namespace octant::survey {

/// All figures of a tile. Integrity's stay untouched where it is not asked for.
void map_tile(const KernelModel& model, const KernelTile& tile, bool integrity, KernelWork& work,
              KernelFigures& figures);

/// Information of beacon `beacon` at the poses of a tile: entry e of pose i at e * kTilePoses + i; heard: 0
/// or 1.
void layer_tile(const KernelModel& model, const KernelTile& tile, std::size_t beacon, double* information,
                double* heard);

}  // namespace octant::survey
