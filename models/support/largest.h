// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

/// Largest plausible values. Larger numbers are input errors, and their squares may overflow. A confusion of
/// units does not reach these bounds; it is detected separately.
inline constexpr double kLargestTof_s = 1e10;    ///< three hundred years; in metres the solar system
inline constexpr double kLargestLength_m = 1e9;  ///< a million kilometres

}  // namespace octant
