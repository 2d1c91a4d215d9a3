// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace octant::io {

/// JSON Schema (draft 2020-12) of a scenario file; schema("scenario") gives it.
[[nodiscard]] std::string_view scenario_schema();

}  // namespace octant::io
