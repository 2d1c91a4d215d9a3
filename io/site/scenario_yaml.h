// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "models/simulator/synthetic.h"
#include "models/support/result.h"

namespace octant::io {

/// Reads a scenario file: `octant_scenario: 1`, `site:` (the content of a site file, with true positions) and
/// the keys of Scenario. Errors name file, line and column. Unknown keys and the site's warnings are in
/// Scenario::warnings.
[[nodiscard]] Result<Scenario> read_scenario(const std::string& path);
/// Reads a scenario from a text; `file` is its name in messages.
[[nodiscard]] Result<Scenario> scenario_from_yaml(std::string_view text, const std::string& file);

/// Text of datasets/hall/scenario.yaml, the world that `octant demo` runs without any argument.
[[nodiscard]] std::string_view bundled_scenario();

}  // namespace octant::io
