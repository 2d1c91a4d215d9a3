// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/commands.h"

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

namespace octant::app {

void add_common_options(CLI::App& app, CommonOptions& common) {
  const OptionGroup group(app, std::string(kCommonGroup));
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.set_version_flag("-V,--version", "octant " OCTANT_VERSION);
  app.add_flag("--json", common.json,
               "Print one JSON object on standard output, on failure too, and nothing else there");
  app.add_flag("-q,--quiet", common.quiet, "No notes and no progress; warnings and errors stay");
  app.add_flag("-v,--verbose", common.verbose, "Say more: notes on standard error, all tables in results");
  add_option(app, "--progress", common.progress, "STYLE", "On standard error: auto, plain, json or none")
      ->check(CLI::IsMember({"auto", "plain", "json", "none"}));
  add_option(app, "--threads", common.threads, "N", "Threads to use; 0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_option(app, "--seed", common.seed, "N", "Seed of everything random");
}

void add_trust_option(CLI::App& command, std::string& trusted_key) {
  add_option(command, "--trusted-key", trusted_key, "PUB",
             "Refuse a deployment that the owner of this public key did not sign")
      ->envname("OCTANT_TRUSTED_KEY");
}

CLI::App* add_command(CLI::App& app, CommonOptions& common, const std::string& name,
                      const std::string& purpose, const std::string& example) {
  CLI::App* command = app.add_subcommand(name, purpose);
  add_common_options(*command, common);
  command->footer("Example:\n  " + example);
  return command;
}

}  // namespace octant::app
