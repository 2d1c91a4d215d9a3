// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace octant {

// Of numbers; kernels have it of their vectors (vector-inl.h).
#include "models/support/small_cholesky.inc"

}  // namespace octant
