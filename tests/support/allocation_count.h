// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace octant::test {

/// Calls of global operator new so far in this process, by all threads.
std::size_t allocations();

}  // namespace octant::test
