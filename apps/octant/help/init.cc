// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "apps/octant/help/help.h"
#include "apps/octant/help/site_template.h"
#include "apps/octant/outputs.h"
#include "io/run/run_ids.h"
#include "io/text/atomic_file.h"

namespace octant::app {
namespace {

struct InitArgs {
  std::string run, output = "-", name = "my-site";
  SiteKind kind = SiteKind::kUltrasound;
};

int init(const InitArgs& args, Session& session) {
  if (args.output == "-" && session.options.json)
    fail_usage("only one of -o - and --json can have standard output", "name a file by -o SITE.yaml");
  check_no_overwriting({.inputs = {args.run}, .outputs = {args.output}});
  // The file is filled in by hand, so an existing one is never overwritten.
  if (args.output != "-" && std::filesystem::exists(args.output))
    fail_usage(fmt::format("'{}' is there already", args.output), "name another file, or remove it first");
  io::RunIds ids{.beacons = {"B0", "B1", "B2", "B3"}, .vehicles = {{"robot", {"r0"}}}};
  if (!args.run.empty()) {
    ids = need(io::read_run_ids(args.run));
    session.warn(ids.warnings);
  }
  const std::string text = site_template(args.kind, args.name, ids);
  if (args.output == "-") return session.finish_document(text);
  check_output(args.output);
  need(io::write_file(args.output, text));
  session.result(fmt::format(
      "{:<17}{}\n{:<17}{} beacons, {} vehicle{}\n{:<17}fill in what is marked <--, then: octant check {} "
      "{}\n",
      "site", args.output, "names", ids.beacons.size(), ids.vehicles.size(),
      ids.vehicles.size() == 1 ? "" : "s", "next", quote_word(args.output),
      args.run.empty() ? "RUN" : quote_word(args.run)));
  return session.finish({{"site", args.output}, {"beacons", ids.beacons}});
}

}  // namespace

void add_init(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] =
      add_command<InitArgs>(app, common, action, "init", "Write a commented site file to fill in",
                            "octant init hall/run -o hall.yaml\n  octant init --for uwb", init);
  add_option(*command, "run", args->run, "RUN", "Run folder: its beacons, vehicles and receivers are named");
  add_option(*command, "-o,--output", args->output, "SITE.yaml", "Site file to write; - is standard output");
  const std::map<std::string, SiteKind> kinds = {
      {"ultrasound", SiteKind::kUltrasound}, {"uwb", SiteKind::kUwb}, {"underwater", SiteKind::kUnderwater}};
  add_option(*command, "--for", args->kind, "KIND",
             "Typical values of: ultrasound (the default), uwb or underwater (sound)")
      ->transform(CLI::CheckedTransformer(kinds, CLI::ignore_case).description(""));
  add_option(*command, "--name", args->name, "NAME", "Name of the site");
}

}  // namespace octant::app
