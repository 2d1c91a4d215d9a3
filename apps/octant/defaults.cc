// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/defaults.h"

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

#include "io/site/defaults_yaml.h"

namespace octant::app {
namespace {

/// Path of the user's file of defaults; empty if there is none.
std::string defaults_path() {
  if (const char* path = std::getenv("OCTANT_DEFAULTS")) return path;
  std::filesystem::path folder;
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config != nullptr && *config != '\0')
    folder = config;
  else if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
    folder = std::filesystem::path(home) / ".config";
  else
    return {};
  const std::filesystem::path file = folder / "octant" / "defaults.yaml";
  std::error_code trouble;
  return std::filesystem::exists(file, trouble) ? file.string() : std::string();
}

}  // namespace

void apply_defaults(Session& session) {
  const std::string path = defaults_path();
  if (path.empty()) return;
  const io::Defaults defaults = need(io::read_defaults(path));
  CommonOptions& options = session.options;
  options.threads = defaults.threads.value_or(options.threads);
  options.progress = defaults.progress.value_or(options.progress);
  options.quiet = defaults.quiet.value_or(options.quiet);
  if (defaults.verbose.value_or(false)) options.verbose = 1;
  session.warn(defaults.warnings);
}

}  // namespace octant::app
