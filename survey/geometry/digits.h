// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Beside quantity.h, which makes lengths and times of it.

#include <string>

namespace octant::survey {

/// A number as people write it: three digits that count, and all digits before the point.
[[nodiscard]] std::string three_digits(double value);

}  // namespace octant::survey
