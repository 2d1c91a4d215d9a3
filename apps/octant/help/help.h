// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/octant/commands.h"

namespace octant::app {

// What a newcomer asks for; one file each.
void add_init(CLI::App& app, CommonOptions& common, Action& action);
void add_help(CLI::App& app, CommonOptions& common, Action& action);
void add_explain(CLI::App& app, CommonOptions& common, Action& action);
void add_completion(CLI::App& app, CommonOptions& common, Action& action);

/// Help of a command or the program as --help prints it: at most 80 columns, a command's own options before
/// the common ones.
[[nodiscard]] std::string help_of(const CLI::App& command);
/// The whole of it as a page for man, from the same words.
[[nodiscard]] std::string man_page(const CLI::App& program);
/// The innermost command that these words name ("history", "trend"); null if there is none.
[[nodiscard]] const CLI::App* command_of(const CLI::App& program, const std::vector<std::string>& words);
/// Names of its commands, of those with a name.
[[nodiscard]] std::vector<std::string> command_names(const CLI::App& program);
/// Long names of a command's options, with their dashes.
[[nodiscard]] std::vector<std::string> option_names(const CLI::App& command);
/// "; did you mean 'x'?", or nothing.
[[nodiscard]] std::string did_you_mean(const std::string& word, const std::vector<std::string>& known);

/// Version and commit in words: "octant 0.2.0 (4e04710)".
[[nodiscard]] std::string version_text();
/// Commit that the program was built from; empty if the sources were in no repository.
[[nodiscard]] std::string_view commit();

}  // namespace octant::app
