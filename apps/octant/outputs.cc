// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/outputs.h"

#include <filesystem>
#include <map>
#include <string_view>

#include <fmt/format.h>
#include <sys/stat.h>

#include "io/run/run_files.h"

namespace octant::app {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLinks = 40;  ///< limit of Linux

/// Canonical path of a file that may not exist yet, with links resolved.
fs::path resolved(fs::path path) {
  std::error_code error;
  for (int i = 0; i < kMostLinks && fs::is_symlink(path, error); ++i) {
    const fs::path target = fs::read_symlink(path, error);
    if (error) break;
    path = target.is_absolute() ? target : path.parent_path() / target;
  }
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const fs::path canonical = fs::weakly_canonical(folder, error);
  return (error ? folder : canonical) / path.filename();
}

bool is_no_file(const std::string& name) {
  std::error_code error;
  if (name.empty() || name == "-") return true;
  const fs::file_status status = fs::status(name, error);
  return fs::exists(status) && !fs::is_regular_file(status) &&
         !fs::is_directory(status);  // pipes and devices store nothing
}

/// Identities of a file for comparison: its path, and its inode for hard links.
std::vector<std::string> identities(const fs::path& file) {
  std::vector<std::string> names = {resolved(file).string()};
  struct stat status {};
  if (::stat(file.c_str(), &status) == 0) names.push_back(fmt::format("{}:{}", status.st_dev, status.st_ino));
  return names;
}

/// Files of an input: the file itself, or all possible files of a run folder.
std::vector<fs::path> files_of(const std::string& input) {
  std::error_code error;
  if (!fs::is_directory(input, error)) return {input};
  std::vector<fs::path> files;
  for (const std::string_view name : io::kRunFiles) files.push_back(fs::path(input) / name);
  return files;
}

}  // namespace

std::vector<std::string> with_files(std::vector<std::string> files, const std::vector<std::string>& more) {
  files.insert(files.end(), more.begin(), more.end());
  return files;
}

void check_no_overwriting(const CommandFiles& files) {
  std::map<std::string, std::string> taken;  // maps identities to descriptions
  for (const std::string& input : files.inputs) {
    if (is_no_file(input)) continue;
    for (const fs::path& file : files_of(input))
      for (const std::string& identity : identities(file))
        taken.emplace(identity, fmt::format("would be written over the input '{}'", file.string()));
  }
  const auto take = [&taken](const std::string& named, const fs::path& file) {
    const std::vector<std::string> names = identities(file);
    for (const std::string& identity : names)
      if (const auto found = taken.find(identity); found != taken.end())
        fail_with({.code = Errc::kUsage,
                   .file = named,
                   .found = found->second,
                   .expected = "a file of its own for each output",
                   .advice = "nothing was read or written"});
    for (const std::string& identity : names)
      taken.emplace(identity, fmt::format("is the output '{}' too", file.string()));
  };
  for (const std::string& name : files.outputs)
    if (!is_no_file(name)) take(name, name);
  for (const std::string& folder : files.run_outputs)
    for (const std::string_view name : io::kRunFiles) take(folder, fs::path(folder) / name);
}

void fail_output(const std::string& path, const std::string& found, const std::string& advice) {
  fail_with({.code = Errc::kOutput, .file = path, .found = found, .advice = advice});
}

void check_output(const std::string& path) {
  if (path == "-" || path.empty()) return;
  std::error_code error;
  if (fs::is_directory(path, error)) fail_output(path, "is a folder", "name a file");
  const fs::path parent = fs::path(path).parent_path();
  if (!parent.empty() && !fs::is_directory(parent, error))
    fail_output(path, fmt::format("the folder '{}' does not exist", parent.string()), "create it first");
}

void check_outputs(const std::vector<std::string>& inputs, const std::vector<OutputOption>& outputs,
                   Session& session) {
  std::vector<std::string> options, paths;
  int files_on_stdout = 0;
  for (const auto& [option, path] : outputs) {
    if (options.empty() || options.back() != option + " -") options.push_back(option + " -");
    paths.push_back(path);
    files_on_stdout += path == "-";
  }
  if (files_on_stdout + session.options.json > 1)
    fail_usage(fmt::format("only one of {} and --json can have standard output", fmt::join(options, ", ")));
  if (files_on_stdout > 0) session.result_to_stderr();
  check_no_overwriting({.inputs = inputs, .outputs = paths});
  for (const std::string& path : paths) check_output(path);
}

}  // namespace octant::app
