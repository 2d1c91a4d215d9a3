// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/network/solve_network.h"

namespace octant::calib {

/// Leaves out points whose ranges fit another position about as well, and adjusts the others again: the
/// mirror image behind the line through their neighbours (in space: the plane), or the position if another
/// range is wrong than the one that was left out. The mirror image of the whole network does not count.
/// @param dimensions  2 where heights are given, else 3
/// @return their names
std::vector<std::string> leave_out_ambiguous(SolvedNetwork& solved, int dimensions);

}  // namespace octant::calib
