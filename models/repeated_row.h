// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

/// Why a row is rejected that stands in a recording twice (RejectedRow::reason).
inline constexpr const char* kRepeatedRow = "the row is a duplicate of another one";

}  // namespace octant
