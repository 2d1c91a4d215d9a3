// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string_view>

namespace octant::io {

/// A name that a site file may have as an id: up to 200 characters on one line.
[[nodiscard]] inline bool is_site_id(std::string_view id) {
  const bool odd = std::ranges::any_of(id, [](unsigned char c) { return c < 0x20 || c == 0x7F; });
  return !id.empty() && id.size() <= 200 && !odd && id.front() != ' ' && id.back() != ' ';
}

}  // namespace octant::io
