// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "apps/octant/help/help.h"
#include "apps/octant/help/site_template.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/steps.h"
#include "io/text/atomic_file.h"

namespace octant::app {
namespace {

struct InitWords {
  std::string run, output = "-", name = "my-site";
  SiteKind kind = SiteKind::kUltrasound;
};

int init(const InitWords& words, Session& session) {
  if (words.output == "-" && session.options.json)
    return session.fail({"error", "usage", kUsage, "only one of -o - and --json can have standard output",
                         "name a file by -o SITE.yaml"});
  if (auto fit = check_no_overwriting({.inputs = {words.run}, .outputs = {words.output}, .run_outputs = {}});
      !fit)
    return session.fail(fit.error());
  // It is to be filled in by hand, and so worth more than a template.
  if (words.output != "-" && std::filesystem::exists(words.output))
    return session.fail({"error", "usage", kUsage, fmt::format("'{}' is there already", words.output),
                         "name another file, or remove it first"});
  io::RunIds ids{.beacons = {"B0", "B1", "B2", "B3"}, .vehicles = {{"robot", {"r0"}}}};
  if (!words.run.empty()) {
    auto found = io::read_run_ids(words.run);
    if (!found) return session.fail(found.error());
    ids = std::move(*found);
  }
  const std::string text = site_template(words.kind, words.name, ids);
  if (words.output == "-") return session.finish_document(text);
  if (auto fit = check_output(words.output); !fit) return session.fail(fit.error());
  if (auto written = io::write_file(words.output, text); !written) return session.fail(written.error());
  session.result(fmt::format(
      "{:<17}{}\n{:<17}{} beacons, {} vehicle{}\n{:<17}fill in what is marked <--, then: octant check {} "
      "{}\n",
      "site", words.output, "names", ids.beacons.size(), ids.vehicles.size(),
      ids.vehicles.size() == 1 ? "" : "s", "next", quote_word(words.output),
      words.run.empty() ? "RUN" : quote_word(words.run)));
  return session.finish({{"site", words.output}, {"beacons", ids.beacons}});
}

}  // namespace

void add_init(CLI::App& app, CommonOptions& common, Action& action) {
  auto words = std::make_shared<InitWords>();
  CLI::App* command = add_command(app, common, "init", "Write a commented site file to fill in",
                                  "octant init hall/run -o hall.yaml\n  octant init --for uwb");
  command->add_option("run", words->run, "Run folder: its beacons, vehicles and receivers are named")
      ->type_name("RUN");
  command->add_option("-o,--output", words->output, "Site file to write; - is standard output")
      ->type_name("SITE.yaml")
      ->capture_default_str();
  const std::map<std::string, SiteKind> kinds = {
      {"ultrasound", SiteKind::kUltrasound}, {"uwb", SiteKind::kUwb}, {"underwater", SiteKind::kUnderwater}};
  command
      ->add_option("--for", words->kind,
                   "Typical values of: ultrasound (the default), uwb or underwater (sound)")
      ->transform(CLI::CheckedTransformer(kinds, CLI::ignore_case).description(""))
      ->type_name("KIND");
  command->add_option("--name", words->name, "Name of the site")->type_name("NAME")->capture_default_str();
  command->callback(
      [words, &action] { action = [words](Session& session) { return init(*words, session); }; });
}

}  // namespace octant::app
