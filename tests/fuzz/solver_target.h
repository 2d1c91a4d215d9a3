// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace octant::fuzz {

/// Calibrates a small world of any kind (small_world.h). Whatever comes of it, no number is a NaN and status
/// and numbers say the same; what converges is a deployment that reads back and localizes.
void take_solver(std::string_view input);

}  // namespace octant::fuzz
