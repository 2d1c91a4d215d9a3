// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "models/support/result.h"

namespace octant::io {

/// A PNG file's content from pixels of red, green, blue and opacity, row by row from the top.
[[nodiscard]] Result<std::string> png_of(const std::vector<std::uint8_t>& rgba, std::size_t columns,
                                         std::size_t rows);

}  // namespace octant::io
