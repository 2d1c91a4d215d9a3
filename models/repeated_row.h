// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

/// Rejection reason (RejectedRow::reason) of a row that occurs twice in a recording.
inline constexpr const char* kRepeatedRow = "the row is a duplicate of another one";

}  // namespace octant
