// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace octant::test {

/// Grows with every call of global operator new or malloc in the process.
[[nodiscard]] std::size_t allocations();

}  // namespace octant::test
