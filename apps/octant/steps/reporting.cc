// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/steps/reporting.h"

#include <filesystem>

#include <fmt/format.h>

#include "apps/octant/help/glossary.h"
#include "apps/octant/options.h"
#include "apps/octant/text/layout.h"
#include "apps/octant/text/report_json.h"
#include "io/deployment/deployment_json.h"
#include "survey/drawing/plan_frame.h"

namespace octant::app {
namespace {

enum class Form { kPage, kMarkdown, kSaved, kUnknown };

Form form_of(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (path == "-" || ending == ".html" || ending == ".htm") return Form::kPage;
  if (ending == ".md") return Form::kMarkdown;
  return ending == ".json" ? Form::kSaved : Form::kUnknown;
}

}  // namespace

void add_report_options(CLI::App& command, ReportArgs& args, bool with_since) {
  auto* report = add_option(command, "--report", args.paths, "R",
                            "Report to write: a page (.html), Markdown (.md), or the content (.json) "
                            "from which `octant report` "
                            "makes the others later; may be given several times")
                     ->expected(1)
                     ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_flag("--report-static", args.still,
                   "Pages without the interactive layer: no script, and small");
  command.add_flag("--no-report", args.none, "None: verdict, table and next steps in the terminal only")
      ->excludes(report);
  if (with_since)
    add_option(command, "--since", args.since, "OLD.json",
               "Report what changed since this earlier deployment");
}

std::vector<OutputOption> report_outputs(const ReportArgs& args, std::vector<OutputOption> outputs) {
  outputs.push_back({"--report", ""});
  for (const std::string& path : args.paths) outputs.push_back({"--report", path});
  return outputs;
}

void check_report(const ReportArgs& args) {
  for (const auto& path : args.paths) {
    if (form_of(path) == Form::kUnknown)
      fail_with({.code = Errc::kUsage,
                 .found = fmt::format("--report {}", path),
                 .expected = "a name that ends in .html, .md or .json"});
    check_output(path);
  }
  if (!args.since.empty()) need(io::read_deployment(args.since));
}

void add_changes(survey::ReportInput& input, const std::string& since) {
  if (!since.empty())
    input.changes = survey::changes_between(need(io::read_deployment(since)), input.plan.deployment);
}

void add_verification(survey::ReportInput& input, const Localization& localization,
                      const survey::Evaluation& evaluation) {
  input.evaluation = evaluation;
  std::vector<Eigen::Vector3d> places;
  for (const Fix& fix : localization.fixes)
    if (fix.ok()) places.push_back(fix.T_map_vehicle.translation_m);
  input.plan.fixes_m = survey::thinned(places);
}

void add_words(survey::ReportInput& input) {
  input.words.clear();
  for (const GlossaryTerm* term : terms_used(survey::report_markdown(input)))
    if (term->kind != GlossaryKind::kExit) input.words.emplace_back(term->name, term->text);
}

std::vector<io::FileContent> report_files(const ReportArgs& args, const survey::ReportInput& content) {
  if (args.paths.empty()) return {};
  std::vector<io::FileContent> files;
  survey::ReportInput input = content;
  add_words(input);
  for (const auto& path : args.paths) {
    switch (form_of(path)) {
      case Form::kMarkdown: files.push_back({path, survey::report_markdown(input)}); break;
      case Form::kSaved: files.push_back({path, report_to_json(input)}); break;
      default: files.push_back({path, survey::report_html(input, {.interactive = !args.still})});
    }
  }
  return files;
}

survey::ReportInput calibration_report(const Calibration& calibration, const ReportArgs& args,
                                       const Session& session) {
  survey::ReportInput input = report_input(calibration, session);
  if (!args.paths.empty()) add_stops(calibration, input);
  if (!calibration.deployment) return input;
  add_changes(input, args.since);
  if (!args.paths.empty()) survey::add_geometry(input, session.threads());
  return input;
}

void write_calibration(const std::string& output, const ReportArgs& args, const Calibration& calibration,
                       const survey::ReportInput& input) {
  auto files = report_files(args, input);
  if (calibration.exported())
    files.push_back({output, need(io::checked_deployment_json(output, *calibration.deployment))});
  need(io::write_files(files));
}

std::string report_lines(const ReportArgs& args) {
  std::string text;
  for (const auto& path : args.paths)
    if (path != "-") text += fmt::format("{:<17}{}\n", "report", path);
  return text;
}

std::string verdict_text(const survey::ReportInput& input) {
  const survey::Verdict v = survey::verdict(input);
  std::string text = named_line("verdict", fmt::format("{}: {}", survey::to_string(v.grade), v.sentence));
  for (const auto& step : survey::next_steps(input)) text += named_line("next", step);
  return text;
}

Json verdict_json(const survey::ReportInput& input) {
  const survey::Verdict v = survey::verdict(input);
  Json gates = Json::array();
  for (const auto& gate : v.gates)
    gates.push_back({{"name", gate.name}, {"value", gate.value}, {"limit", gate.limit}, {"pass", gate.pass}});
  return {{"grade", survey::to_string(v.grade)},
          {"sentence", v.sentence},
          {"contradictions", io::json_of(input.plan.deployment.contradictions)},
          {"gates", gates},
          {"next", survey::next_steps(input)}};
}

}  // namespace octant::app
