// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace octant::survey {

// Trusted text of the pages. The palette is given as custom properties, once for light and once for dark; a
// test computes the contrast of each pair that meets.
[[nodiscard]] std::string_view page_style();
/// Draws the figures with plotly.js where the browser can; without it everything stays as it is.
[[nodiscard]] std::string_view page_script();

}  // namespace octant::survey
