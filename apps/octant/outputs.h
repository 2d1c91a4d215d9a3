// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/support/result.h"

namespace octant::app {

/// What a command reads and what it writes, as named on its command line; "-" and the empty word are no file.
struct CommandFiles {
  std::vector<std::string> inputs;       ///< files, and run folders with all that belongs to a run
  std::vector<std::string> outputs;      ///< files
  std::vector<std::string> run_outputs;  ///< folders that become runs
};

/// Before anything is read: no output may be one of the inputs or another output. Files are told apart by
/// what they are on the disk, through links and under whatever name; an output into an input's run folder
/// under a name that a run gives meaning to is one of its files whether it lies there or not. Errors: kUsage,
/// both names.
[[nodiscard]] Result<void> check_no_overwriting(const CommandFiles& files);

}  // namespace octant::app
