// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/octant/session.h"

namespace octant::app {

/// Inputs and outputs on the command line of a command; "-" and an empty text are no files.
struct CommandFiles {
  std::vector<std::string> inputs{};       ///< files, and run folders with all their files
  std::vector<std::string> outputs{};      ///< files
  std::vector<std::string> run_outputs{};  ///< folders in which runs are written
};
[[nodiscard]] std::vector<std::string> with_files(std::vector<std::string> files,
                                                  const std::vector<std::string>& more);

/// Checks, before reading, that no output is one of the inputs or another output. Files are compared by
/// identity, through links. A file that a run may contain counts as part of an input's run folder, even if it
/// does not exist. Failures: kUsage, with both names.
void check_no_overwriting(const CommandFiles& files);

/// Ends the command because an output cannot be written.
[[noreturn]] void fail_output(const std::string& path, const std::string& found,
                              const std::string& advice = "");
/// Fails early if an output could not be written: its folder is missing, or it is a folder.
void check_output(const std::string& path);

/// An option such as "-o" with its path; empty if it was not given.
struct OutputOption {
  std::string option, path;
};

/// Checks, before reading, that at most one of the outputs and --json uses standard output (messages then go
/// to standard error), that none overwrites an input or another output, and that each can be written.
void check_outputs(const std::vector<std::string>& inputs, const std::vector<OutputOption>& outputs,
                   Session& session);

}  // namespace octant::app
