// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

/// Median absolute deviation of normal noise with sigma 1.
inline constexpr double kMedianOfNormal = 0.6745;

}  // namespace octant
