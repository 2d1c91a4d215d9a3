// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: sigma of a fix without some layers of beacons (layer_tile in map_kernel.h).

#include <cstddef>

namespace octant::survey {

/// Horizontal sigma of packed information (entry e of pose i at e * stride + i) without up to two layers, for
/// `count` poses. kNoFix if the result is singular compared with the full information.
void sigma_of_packed(int unknowns, const double* information, const double* less, const double* less_too,
                     std::size_t stride, std::size_t count, double* sigma_m);

/// sum[i] += term[i]
void add_to(const double* term, std::size_t count, double* sum);

}  // namespace octant::survey
