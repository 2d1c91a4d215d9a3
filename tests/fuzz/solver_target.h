// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace octant::fuzz {

/// Calibrates a small world of any kind (small_world.h). For any outcome, no number is NaN and status and
/// numbers agree; a solution that converges is a deployment that reads back and localizes.
void take_solver(std::string_view input);

}  // namespace octant::fuzz
