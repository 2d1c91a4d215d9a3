// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/octant/commands.h"

namespace octant::app {

// Commands for beginners; each is defined in the file of the same name.
void add_init(CLI::App& app, CommonOptions& common, Action& action);
void add_help(CLI::App& app, CommonOptions& common, Action& action);
void add_explain(CLI::App& app, CommonOptions& common, Action& action);
void add_completion(CLI::App& app, CommonOptions& common, Action& action);

/// Help text of a command or the program, as printed by --help: at most 80 columns, own options before the
/// common ones.
[[nodiscard]] std::string help_of(const CLI::App& command);
/// The complete help as a man page, generated from the same texts.
[[nodiscard]] std::string man_page(const CLI::App& program);
/// Finds the innermost command for a list of words ("history", "trend"); null if there is none.
[[nodiscard]] const CLI::App* command_of(const CLI::App& program, const std::vector<std::string>& words);
/// Names of the subcommands of a program.
[[nodiscard]] std::vector<std::string> command_names(const CLI::App& program);
/// Long names of a command's options, with their dashes.
[[nodiscard]] std::vector<std::string> option_names(const CLI::App& command);
/// "; did you mean 'x'?", or an empty text.
[[nodiscard]] std::string did_you_mean(const std::string& word, const std::vector<std::string>& known);

/// Version and commit in words: "octant 0.2.0 (4e04710)".
[[nodiscard]] std::string version_text();
/// Commit that the program was built from; empty if the sources were not in a repository.
[[nodiscard]] std::string_view commit();

}  // namespace octant::app
