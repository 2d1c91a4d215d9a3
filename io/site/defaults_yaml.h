// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/support/result.h"

namespace octant::io {

/// Options that a user would otherwise repeat with every command. Only options that change no result are
/// allowed, so that a deployment never depends on a hidden file.
struct Defaults {
  std::optional<int> threads;           ///< 0: all cores
  std::optional<std::string> progress;  ///< "auto", "plain", "json" or "none"
  std::optional<bool> quiet, verbose;
  std::vector<std::string> warnings;
};

/// Reads a file of defaults:
///   octant_defaults: 1
///   threads: 2
///   verbose: true
/// Errors name line and column.
[[nodiscard]] Result<Defaults> read_defaults(const std::string& path);

}  // namespace octant::io
