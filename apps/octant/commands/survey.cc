// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/survey.h"

#include <memory>

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

Result<survey::Survey> look(const SurveyArgs& words, Session& session) {
  const ExitAtOnce nothing_written_yet;
  auto input = read_survey_input(words.input, words.scene, words.vehicle, words.cell_m, session);
  if (!input) return fail(input.error());
  const Deployment* deployment = input->deployment ? &*input->deployment : nullptr;
  return survey::run_survey(input->model, input->scene, deployment,
                            {.threads = session.threads(), .failures = words.failures});
}

/// Report, CSV and maps; what was written, for people and machines.
Result<Json> write_survey_outputs(const SurveyArgs& words, const survey::Survey& survey,
                                  const std::optional<survey::FloorSchedule>& schedule,
                                  const Session& session) {
  Json written = Json::array();
  if (!words.csv.empty()) {
    if (auto done = io::write_file(words.csv, survey::survey_csv(survey)); !done) return fail(done.error());
    if (words.csv != "-") written.push_back(words.csv);
  }
  if (!words.maps.empty()) {
    const auto files = write_maps(survey, words.maps);
    if (!files) return fail(files.error());
    for (const std::string& file : *files) written.push_back(words.maps + "/" + file);
  }
  if (!words.report.empty()) {
    const survey::SurveyPageInput about{.input = words.input,
                                        .created = created_now(),
                                        .program = "octant " OCTANT_VERSION,
                                        .command = session.command_line,
                                        .warnings = session.warnings(),
                                        .schedule = schedule};
    const std::string page = words.report.ends_with(".md")
                                 ? survey::to_markdown(survey::survey_document(survey, about))
                                 : survey::survey_html(survey, about, !words.still);
    if (auto done = io::write_file(words.report, page); !done) return fail(done.error());
    if (words.report != "-") written.push_back(words.report);
  }
  return written;
}

/// With what the survey itself names: plans that were imported, a file for each map.
CommandFiles files_of(const SurveyArgs& words, const survey::Survey& survey) {
  CommandFiles files{
      .inputs = survey.scene.imported, .outputs = {words.report, words.csv}, .run_outputs = {}};
  files.inputs.insert(files.inputs.end(), {words.input, words.scene});
  if (words.maps.empty()) return files;
  const auto maps = map_files(survey, words.maps);
  files.outputs.insert(files.outputs.end(), maps.begin(), maps.end());
  return files;
}

int run(const SurveyArgs& words, Session& session) {
  const int on_stdout = (words.report == "-") + (words.csv == "-") + session.options.json;
  if (on_stdout > 1)
    return session.fail(
        {"error", "usage", kUsage, "only one of -o -, --csv - and --json can have standard output", ""});
  if (words.report == "-" || words.csv == "-") session.result_to_stderr();
  if (auto fit = check_no_overwriting(
          {.inputs = {words.input, words.scene}, .outputs = {words.report, words.csv}, .run_outputs = {}});
      !fit)
    return session.fail(fit.error());
  for (const auto& path : {words.report, words.csv})
    if (auto fit = check_output(path); !path.empty() && !fit) return session.fail(fit.error());
  const auto survey = look(words, session);
  if (!survey) return session.fail(survey.error());
  if (interrupted()) return session.interrupted();
  if (auto fit = check_no_overwriting(files_of(words, *survey)); !fit) return session.fail(fit.error());
  const auto schedule = survey::schedule_of_survey(survey->model, survey->scene, session.threads());
  const auto written = write_survey_outputs(words, *survey, schedule, session);
  if (!written) return session.fail(written.error());
  session.result(survey_summary(*survey, schedule));
  for (const std::string& path : {words.report, words.csv, words.maps})
    if (!path.empty() && path != "-") session.result(fmt::format("{:<17}{}\n", "written", path));
  if (session.options.verbose > 0) session.result("\n" + survey_text(*survey, schedule));
  Json object = survey_json(*survey, schedule, words.bins);
  object["seconds"] = session.seconds();
  object["written"] = *written;
  return session.finish(object);
}

}  // namespace

void add_survey(CLI::App& app, CommonOptions& common, Action& action) {
  auto words = std::make_shared<SurveyArgs>();
  CLI::App* command = add_command(app, common, "survey",
                                  "What a geometry is worth: who is heard where, how well one is positioned, "
                                  "what a beacon's failure costs",
                                  "octant survey aisles/site.yaml -o aisles/survey.html --maps aisles/maps");
  command->add_option("input", words->input, "Site file, or a deployment: then with the calibration's part")
      ->required()
      ->type_name("SITE.yaml|DEPLOYMENT.json");
  command
      ->add_option("--scene", words->scene,
                   "Scene file: floor, walls, patterns, routes; goes before the site's own scene block")
      ->type_name("S.yaml");
  command
      ->add_option("-o,--output,--report", words->report,
                   "Report to write: a page, or Markdown where its name ends in .md; - is standard output")
      ->type_name("R.html");
  command->add_flag("--report-static", words->still,
                    "A page without the interactive layer: no script, and small");
  command->add_option("--csv", words->csv, "All figures of all cells to write")->type_name("F.csv");
  command
      ->add_option("--maps", words->maps, "Folder to write every map to: SVG, PNG, PGM and YAML for ROS, CSV")
      ->type_name("DIR");
  command->add_option("--vehicle", words->vehicle, "Whose receivers hear; else the first vehicle's")
      ->type_name("ID");
  command->add_option("--cell", words->cell_m, "Size of a cell in metres, instead of the scene's cell_m")
      ->type_name("M");
  command->add_option("--failures", words->failures, "How many beacons may fail at once")
      ->check(CLI::Range(0, 2))
      ->capture_default_str()
      ->type_name("N");
  command
      ->add_option("--bins", words->bins,
                   "With --json: values of every map, so many bins along the longer side")
      ->type_name("N");
  command->callback(
      [words, &action] { action = [words](Session& session) { return run(*words, session); }; });
}

}  // namespace octant::app
