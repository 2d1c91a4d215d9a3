// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/octant/session.h"

namespace octant::app {

/// What a command reads and what it writes, as named on its command line; "-" and the empty word are no file.
struct CommandFiles {
  std::vector<std::string> inputs{};       ///< files, and run folders with all that belongs to a run
  std::vector<std::string> outputs{};      ///< files
  std::vector<std::string> run_outputs{};  ///< folders that become runs
};
[[nodiscard]] std::vector<std::string> with_files(std::vector<std::string> files,
                                                  const std::vector<std::string>& more);

/// Before anything is read: no output may be one of the inputs or another output. Files are told apart by
/// what they are on the disk, through links and under whatever name; an output into an input's run folder
/// under a name that a run gives meaning to is one of its files whether it lies there or not. Failures:
/// kUsage, both names.
void check_no_overwriting(const CommandFiles& files);

/// Ends the command because an output cannot be written.
[[noreturn]] void fail_output(const std::string& path, const std::string& found,
                              const std::string& advice = "");
/// Fails early where an output could not be written anyway: its folder is missing, or it is a folder.
void check_output(const std::string& path);

/// What an option ("-o") was given; empty: it was not.
struct OutputOption {
  std::string option, path;
};

/// Before anything is read: at most one of the outputs and --json has standard output (where a file has it,
/// words go to standard error), none is written over an input or another output, and each can be written.
void check_outputs(const std::vector<std::string>& inputs, const std::vector<OutputOption>& outputs,
                   Session& session);

}  // namespace octant::app
