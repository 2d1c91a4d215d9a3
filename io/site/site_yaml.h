// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/site.h"
#include "models/support/result.h"

namespace octant::io {

/// Reads a site file (contract: site.yaml). Errors name file, line and column, what was found, what was
/// expected. Unknown keys are warnings in Site::warnings.
[[nodiscard]] Result<Site> read_site(const std::string& path);
/// Text of a site file; read_site of it gives the same site back.
[[nodiscard]] std::string site_to_yaml(const Site& site);

}  // namespace octant::io
