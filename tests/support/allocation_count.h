// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace octant::test {

/// Number of calls of the global operator new so far in this process.
[[nodiscard]] std::size_t allocations();

}  // namespace octant::test
