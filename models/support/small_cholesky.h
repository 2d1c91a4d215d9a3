// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace octant {

// Scalar version; kernels instantiate it for their vectors (vector-inl.h).
#include "models/support/small_cholesky.inc"

}  // namespace octant
