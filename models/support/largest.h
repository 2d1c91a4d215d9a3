// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

/// Beyond these a number is a fault of whoever wrote it, whose square may be no number any more. A unit taken
/// for another is nowhere near them, and is told as such.
inline constexpr double kLargestTof_s = 1e10;    ///< three hundred years; in metres the solar system
inline constexpr double kLargestLength_m = 1e9;  ///< a million kilometres

}  // namespace octant
