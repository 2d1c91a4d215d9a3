// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/help/help.h"
#include "io/schema/schema.h"

namespace octant::app {
namespace {

/// Files with names of their own, and the format that describes them.
constexpr std::array<std::pair<const char*, const char*>, 22> kFileNames = {
    {{"site.yaml", "site"},     {"tof.csv", "run"},
     {"odometry.csv", "run"},   {"odometry.tum", "run"},
     {"bearings.csv", "run"},   {"scans.csv", "run"},
     {"points.csv", "run"},     {"poses.tum", "run"},
     {"truth.csv", "run"},      {"truth.tum", "run"},
     {"run.yaml", "run"},       {"deployment.json", "deployment"},
     {"fixes.csv", "fixes"},    {"fixes.tum", "fixes"},
     {"cells.csv", "survey"},   {"routes.csv", "survey"},
     {"survey.yaml", "survey"}, {"columns.yaml", "columns"},
     {"topics.yaml", "topics"}, {"scenario.yaml", "scenario"},
     {"sites.yaml", "batch"},   {"defaults.yaml", "defaults"}}};

constexpr std::array<const char*, 13> kFormats = {"site",    "run",     "deployment", "fixes", "survey",
                                                  "columns", "topics",  "scenario",   "scene", "batch",
                                                  "live",    "cockpit", "defaults"};

/// "site, run, ... or defaults; or a file's name, such as cells.csv"
std::string formats_in_words() {
  std::string words;
  for (const char* format : kFormats)
    words += (words.empty() ? "" : format == kFormats.back() ? " or " : ", ") + std::string(format);
  return words + "; or a file's name, such as cells.csv";
}

std::vector<std::string> known_formats() {
  std::vector<std::string> known(kFormats.begin(), kFormats.end());
  for (const auto& [file, format] : kFileNames) known.emplace_back(file);
  return known;
}

/// Format of a file name; other names are returned unchanged.
std::string format_named(const std::string& name) {
  const auto file = std::ranges::find_if(kFileNames, [&](const auto& known) { return name == known.first; });
  return file == kFileNames.end() ? name : file->second;
}

struct SchemaArgs {
  std::string format;
  bool page = false;
};

int print_schema(const SchemaArgs& args, Session& session) {
  const auto& [name, page] = args;
  const std::string format = format_named(name);
  if (io::schema(format).empty())
    fail_usage(fmt::format("there is no format '{}'{}", name, did_you_mean(name, known_formats())),
               fmt::format("expected {}", formats_in_words()));
  if (page && session.options.json) fail_usage("--page is no JSON", "leave out one of --page and --json");
  if (page) return session.finish_document(io::schema_page(format, name));
  // The schema is a JSON object already, so --json has no effect.
  return session.finish_document(io::schema_of_file(format, name));
}

}  // namespace

void add_schema(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<SchemaArgs>(
      app, common, action, "schema", "Print the JSON Schema of a file format, with a word on every key",
      "octant schema deployment > deployment.schema.json", print_schema);
  add_required_option(*command, "format", args->format, "FORMAT", formats_in_words());
  command->add_flag("--page", args->page, "Instead: a page of Markdown, a row for each key and column");
}

}  // namespace octant::app
