// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace octant::survey {

/// plotly.js (MIT, Plotly Inc.), minified, gzip, in base64; empty if it was not available when the program
/// was built.
[[nodiscard]] std::string_view plotly_js();
[[nodiscard]] std::string_view plotly_js_version();

}  // namespace octant::survey
