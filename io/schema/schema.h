// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace octant::io {

/// JSON Schema (draft 2020-12) of one of the formats: "site", "run", "deployment", "scenario", "scene",
/// "batch", "live", "fixes", "survey", "columns", "topics", "defaults"; empty for another name.
[[nodiscard]] std::string_view schema(std::string_view format);

}  // namespace octant::io
