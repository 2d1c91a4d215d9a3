// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace octant::app {

// Files of the page, embedded by octant_embed().
[[nodiscard]] std::string_view cockpit_html();
[[nodiscard]] std::string_view cockpit_css();
[[nodiscard]] std::string_view cockpit_js();
[[nodiscard]] std::string_view cockpit_plan_js();

}  // namespace octant::app
