// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/survey.h"

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/survey_input.h"
#include "apps/octant/text/survey_text.h"
#include "io/text/atomic_file.h"
#include "survey/map/survey_csv.h"
#include "survey/page/report_markdown.h"
#include "survey/page/survey_page.h"

namespace octant::app {
namespace {

struct SurveyArgs {
  std::string input, scene, vehicle, report, csv, maps;
  std::optional<double> cell_m;
  int failures = 2;
  std::size_t bins = 0;
  bool still = false;
};

survey::Survey look(const SurveyArgs& args, Session& session) {
  const ExitAtOnce nothing_written_yet;
  const auto input = read_survey_input(args.input, args.scene, args.vehicle, args.cell_m, session);
  const Deployment* deployment = input.deployment ? &*input.deployment : nullptr;
  return need(survey::run_survey(input.model, input.scene, deployment,
                                 {.threads = session.threads(), .failures = args.failures}));
}

/// Writes report, CSV and maps. Returns the list of outputs for people and machines.
Json write_survey_outputs(const SurveyArgs& args, const survey::Survey& survey,
                          const std::optional<survey::FloorSchedule>& schedule, const Session& session) {
  Json written = Json::array();
  const auto write = [&written](const std::string& path, const std::string& content) {
    need(io::write_file(path, content));
    if (path != "-") written.push_back(path);
  };
  if (!args.csv.empty()) write(args.csv, survey::survey_csv(survey));
  if (!args.maps.empty())
    for (const std::string& file : write_maps(survey, args.maps)) written.push_back(args.maps + "/" + file);
  if (!args.report.empty()) {
    const survey::SurveyPageInput about{.input = args.input,
                                        .created = created_now(),
                                        .program = "octant " OCTANT_VERSION,
                                        .command = session.command_line,
                                        .warnings = session.warnings(),
                                        .schedule = schedule};
    write(args.report, args.report.ends_with(".md")
                           ? survey::to_markdown(survey::survey_document(survey, about))
                           : survey::survey_html(survey, about, !args.still));
  }
  return written;
}

/// Files including those that the survey itself names: imported plans, and one file for each map.
CommandFiles files_of(const SurveyArgs& args, const survey::Survey& survey) {
  CommandFiles files{.inputs = survey.scene.imported, .outputs = {args.report, args.csv}};
  files.inputs.insert(files.inputs.end(), {args.input, args.scene});
  if (args.maps.empty()) return files;
  const auto maps = map_files(survey, args.maps);
  files.outputs.insert(files.outputs.end(), maps.begin(), maps.end());
  return files;
}

int run(const SurveyArgs& args, Session& session) {
  check_outputs({args.input, args.scene}, {{"-o", args.report}, {"--csv", args.csv}}, session);
  const survey::Survey survey = look(args, session);
  stop_if_interrupted();
  check_no_overwriting(files_of(args, survey));
  const auto schedule = survey::schedule_of_survey(survey.model, survey.scene, session.threads());
  const Json written = write_survey_outputs(args, survey, schedule, session);
  session.result(survey_summary(survey, schedule));
  for (const std::string& path : {args.report, args.csv, args.maps})
    if (!path.empty() && path != "-") session.result(fmt::format("{:<17}{}\n", "written", path));
  if (session.options.verbose > 0) session.result("\n" + survey_text(survey, schedule));
  Json object = survey_json(survey, schedule, args.bins);
  object["seconds"] = session.seconds();
  object["written"] = written;
  return session.finish(object);
}

}  // namespace

void add_survey(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] =
      add_command<SurveyArgs>(app, common, action, "survey",
                              "What a geometry is worth: who is heard where, how well one is positioned, "
                              "what a beacon's failure costs",
                              "octant survey aisles/site.yaml -o aisles/survey.html --maps aisles/maps", run);
  add_required_option(*command, "input", args->input, "SITE.yaml|DEPLOYMENT.json",
                      "Site file, or a deployment: then with the calibration's part");
  add_option(*command, "--scene", args->scene, "S.yaml",
             "Scene file: floor, walls, patterns, routes; goes before the site's own scene block");
  add_option(*command, "-o,--output,--report", args->report, "R.html",
             "Report to write: a page, or Markdown where its name ends in .md; - is standard output");
  command->add_flag("--report-static", args->still,
                    "A page without the interactive layer: no script, and small");
  add_option(*command, "--csv", args->csv, "F.csv", "All figures of all cells to write");
  add_option(*command, "--maps", args->maps, "DIR",
             "Folder to write every map to: SVG, PNG, PGM and YAML for ROS, CSV");
  add_option(*command, "--vehicle", args->vehicle, "ID", "Whose receivers hear; else the first vehicle's");
  add_option(*command, "--cell", args->cell_m, "M",
             "Size of a cell in metres, instead of the scene's cell_m");
  add_option(*command, "--failures", args->failures, "N", "How many beacons may fail at once")
      ->check(CLI::Range(0, 2));
  add_option(*command, "--bins", args->bins, "N",
             "With --json: values of every map, so many bins along the longer side");
}

}  // namespace octant::app
