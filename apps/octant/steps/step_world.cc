// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <system_error>

#include <fmt/format.h>
#include <sys/stat.h>

#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/steps.h"
#include "io/deployment/deployment_json.h"
#include "io/run/run_files.h"
#include "io/site/site_yaml.h"
#include "io/text/atomic_file.h"
#include "io/text/staging.h"

namespace octant::app {
namespace {

namespace fs = std::filesystem;

/// First entry of the folder that no world has, if any.
std::optional<fs::path> stranger_in(const fs::path& folder, const std::vector<std::string>& may_replace) {
  std::set<std::string> known = {"site.yaml", "scenario.yaml", "deployment.true.json", "run", "heldout"};
  known.insert(may_replace.begin(), may_replace.end());
  const std::set<std::string> known_of_run(std::begin(io::kRunFiles), std::end(io::kRunFiles));
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    const bool run_folder = it.depth() == 0 && (name == "run" || name == "heldout");
    if (it->is_symlink() || it->is_directory() != run_folder ||
        (it.depth() == 0 ? known : known_of_run).count(name) == 0)
      return it->path();
  }
  if (error) return folder;
  return std::nullopt;
}

void check_world_folder(const fs::path& folder, const std::vector<std::string>& may_replace) {
  std::error_code error;
  const auto status = fs::status(folder, error);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status)) fail_output(folder, "is a file", "name a folder");
  if (const auto stranger = stranger_in(folder, may_replace))
    fail_output(folder,
                fmt::format("holds something that is not a simulated world ({})",
                            stranger->lexically_relative(folder).string()),
                "name an empty or a new folder");
}

/// Creates a folder next to the one that it will replace, and removes remains of killed processes.
fs::path make_sibling(const fs::path& folder) {
  constexpr int kTries = 100;
  const fs::path parent = folder.has_parent_path() ? folder.parent_path() : fs::path(".");
  std::error_code error;
  fs::create_directories(parent, error);
  if (error) fail_output(parent, error.message());
  io::remove_stale_beside(folder.string());
  for (int tries = 0; tries < kTries; ++tries) {
    fs::path sibling = io::staging_name(folder.string());
    if (::mkdir(sibling.c_str(), 0777) == 0) return sibling;
    if (errno != EEXIST) break;  // otherwise, a process with this number on another machine
  }
  fail_output(parent, std::strerror(errno), "choose a folder that can be written");
}

void write_content(const fs::path& at, const World& world, std::string_view scenario_text) {
  const NameTable names = names_of(world.site);
  const auto unless_interrupted = [](auto&& write) {
    stop_if_interrupted();
    need(write());
  };
  unless_interrupted([&] { return io::write_file(at / "site.yaml", io::site_to_yaml(world.site)); });
  unless_interrupted([&] { return io::write_file(at / "scenario.yaml", scenario_text); });
  unless_interrupted([&] { return io::write_run(at / "run", world.run, names); });
  unless_interrupted([&] { return io::write_run(at / "heldout", world.heldout, names); });
  unless_interrupted([&] { return io::write_deployment(at / "deployment.true.json", world.truth); });
}

/// Moves every entry of `fresh` into `target`, and the previous entries into `old`. The folder itself
/// remains, because it may be the current folder of a process.
std::error_code exchange_content(const fs::path& fresh, const fs::path& target, const fs::path& old) {
  std::error_code error;
  std::vector<fs::path> names, before;
  for (fs::directory_iterator it(fresh, error), end; !error && it != end; it.increment(error))
    names.push_back(it->path().filename());
  for (fs::directory_iterator it(target, error), end; !error && it != end; it.increment(error))
    before.push_back(it->path().filename());
  for (const auto& name : before)
    if (!error) fs::rename(target / name, old / name, error);
  for (const auto& name : names)
    if (!error) fs::rename(fresh / name, target / name, error);
  return error;
}

}  // namespace

World simulated(const Scenario& scenario, const Session& session) {
  const ExitAtOnce nothing_written_yet;
  World world = need(simulate(scenario, session.options.seed));
  world.truth.created = created_now();
  world.truth.program_version = OCTANT_VERSION;
  world.truth.program_command = session.command_line;
  return world;
}

void write_world(const std::string& folder, const World& world, std::string_view scenario_text,
                 const std::vector<std::string>& may_replace) {
  std::error_code error;
  fs::path target = fs::weakly_canonical(folder, error);
  if (error) fail_output(folder, error.message());
  if (!target.has_filename()) target = target.parent_path();
  check_world_folder(target, may_replace);
  io::StagedFolder fresh(make_sibling(target));
  write_content(fresh.path(), world, scenario_text);
  if (fs::exists(target, error)) {
    const io::StagedFolder old(make_sibling(target));
    error = exchange_content(fresh.path(), target, old.path());
  } else {
    fs::rename(fresh.path(), target, error);
    if (!error) fresh.keep();
  }
  if (error) fail_output(target, error.message());
}

}  // namespace octant::app
