// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <CLI/App.hpp>

#include "models/deployment.h"
#include "models/support/result.h"

namespace octant::app {

/// --trusted-key, or OCTANT_TRUSTED_KEY in the environment.
void add_trust_option(CLI::App& command, std::string& trusted_key);

/// A deployment; with a trusted key only one that its owner signed. Errors: those of reading, of an unsigned
/// one, of another key.
[[nodiscard]] Result<Deployment> read_trusted_deployment(const std::string& path,
                                                         const std::string& trusted_key);

}  // namespace octant::app
