// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <CLI/App.hpp>

#include "apps/octant/options.h"
#include "apps/octant/session.h"

namespace octant::app {

// Add the commands to the command line. Each is defined in the file of the same name.
void add_demo(CLI::App& app, CommonOptions& common, Action& action);
void add_simulate(CLI::App& app, CommonOptions& common, Action& action);
void add_check(CLI::App& app, CommonOptions& common, Action& action);
void add_calibrate(CLI::App& app, CommonOptions& common, Action& action);
void add_recalibrate(CLI::App& app, CommonOptions& common, Action& action);
void add_monitor(CLI::App& app, CommonOptions& common, Action& action);
void add_diff(CLI::App& app, CommonOptions& common, Action& action);
void add_adjust(CLI::App& app, CommonOptions& common, Action& action);
void add_batch(CLI::App& app, CommonOptions& common, Action& action);
void add_localize(CLI::App& app, CommonOptions& common, Action& action);
void add_verify(CLI::App& app, CommonOptions& common, Action& action);
void add_survey(CLI::App& app, CommonOptions& common, Action& action);
void add_convert(CLI::App& app, CommonOptions& common, Action& action);
void add_export(CLI::App& app, CommonOptions& common, Action& action);
void add_cockpit(CLI::App& app, CommonOptions& common, Action& action);
void add_plan(CLI::App& app, CommonOptions& common, Action& action);
void add_report(CLI::App& app, CommonOptions& common, Action& action);
void add_history(CLI::App& app, CommonOptions& common, Action& action);
void add_sign(CLI::App& app, CommonOptions& common, Action& action);
void add_verify_signature(CLI::App& app, CommonOptions& common, Action& action);
void add_schema(CLI::App& app, CommonOptions& common, Action& action);

/// Adds a command with the common options. @param example  shown by --help
[[nodiscard]] CLI::App* add_command(CLI::App& app, CommonOptions& common, const std::string& name,
                                    const std::string& purpose, const std::string& example);
/// Adds a command with its own arguments. main() calls `run` if the command line names the command.
template <class Args>
[[nodiscard]] std::pair<CLI::App*, Args*> add_command(
    CLI::App& app, CommonOptions& common, Action& action, const std::string& name, const std::string& purpose,
    const std::string& example, std::type_identity_t<int (*)(const Args&, Session&)> run) {
  auto args = std::make_shared<Args>();
  CLI::App* command = add_command(app, common, name, purpose, example);
  set_action(*command, args, action, run);
  return {command, args.get()};
}
void add_common_options(CLI::App& app, CommonOptions& common);
/// --trusted-key, or OCTANT_TRUSTED_KEY in the environment.
void add_trust_option(CLI::App& command, std::string& trusted_key);

}  // namespace octant::app
