// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/support/result.h"

namespace octant::io {

/// What somebody would otherwise type with every command. Only what changes no result is here, so that a
/// deployment does not hang on a file that nobody sees.
struct Defaults {
  std::optional<int> threads;           ///< 0: all cores
  std::optional<std::string> progress;  ///< auto, plain, json or none
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
