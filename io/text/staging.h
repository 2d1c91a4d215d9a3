// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/text/open_file.h"

namespace octant::io {

/// A name for what will become the target, beside it: TARGET.PID.COUNT.tmp, another one at each call.
[[nodiscard]] std::string staging_name(const std::string& target);

/// What a process that was killed left beside a target.
struct StaleStaging {
  std::filesystem::path path;
  Descriptor lock;  ///< held until it is removed, so that nobody else takes it
};

/// Files and folders staged for a target whose process is gone and that nobody holds (a process on another
/// machine, or in another container, locks its own).
[[nodiscard]] std::vector<StaleStaging> stale_beside(const std::string& target);

}  // namespace octant::io
