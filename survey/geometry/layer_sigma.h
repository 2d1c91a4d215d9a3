// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: what is left of a fix where layers of beacons (layer_tile in map_kernel.h) are taken
// away.

#include <cstddef>

namespace octant::survey {

/// Horizontal sigma of packed information (entry e of pose i at e * stride + i) less that of up to two
/// layers; `count` poses. Singular by comparison with what was there before the layers were taken away:
/// kNoFix.
void sigma_of_packed(int unknowns, const double* information, const double* less, const double* less_too,
                     std::size_t stride, std::size_t count, double* sigma_m);

/// sum[i] += term[i]
void add_to(const double* term, std::size_t count, double* sum);

}  // namespace octant::survey
