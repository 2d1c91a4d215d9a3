// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/reporting.h"
#include "apps/octant/text/changes_text.h"
#include "apps/octant/text/report_json.h"
#include "io/deployment/deployment_json.h"
#include "io/text/bounds.h"
#include "survey/page/report_html.h"
#include "survey/page/report_markdown.h"
#include "survey/page/site_sheet.h"
#include "survey/report/certificate.h"

namespace octant::app {
namespace {

struct ReportArgs {
  std::string saved;
  std::vector<std::string> runs;
  ReportWords report;
  std::string site_sheet;
  std::string certificate;
  survey::CertificateInput certified;
};

/// The digest that the file carries; of a file without one, that of its bytes.
std::string digest_of(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_object() && json.contains("digest") && json["digest"].is_string()) return json["digest"];
  return io::sha256_hex(text);
}

/// What was saved, whole; or what a deployment says, with its geometry.
Result<survey::ReportInput> read_saved(const std::string& text, const ReportArgs& words, Session& session) {
  if (is_saved_report(text)) {
    auto saved = report_from_json(text, words.saved);
    if (saved) saved->command = session.command_line;
    return saved;
  }
  const auto deployment = io::deployment_from_json(text, words.saved);
  if (!deployment) return fail(deployment.error());
  survey::ReportInput input = report_input(*deployment, session);
  survey::add_geometry(input, session.threads());
  return input;
}

Result<void> verify_with(const std::vector<std::string>& folders, survey::ReportInput& input,
                         Session& session) {
  if (folders.empty()) return {};
  const Deployment& d = input.plan.deployment;
  if (input.outcome != survey::Outcome::kCalibrated)
    return fail({.code = Errc::kUsage,
                 .found = "runs beside the report of a calibration that exported nothing",
                 .expected = "a report or a deployment that has beacons"});
  const auto runs = read_runs(
      folders, names_of(d), d.timing,
      {.read_truth = true, .read_poses = false, .constant_speed_mps = constant_speed_mps(d.medium)}, session);
  if (!runs) return fail(runs.error());
  const auto found = localize_runs(d, *runs, Method::kAuto);
  if (!found) return fail(found.error());
  const auto evaluation = verify_fixes(d, *runs, *found);
  if (!evaluation) return fail(evaluation.error());
  add_verification(input, *found, *evaluation);
  return {};
}

/// As Markdown where its name says so, else as a page without a script.
std::string certificate_page(const ReportArgs& words, const survey::ReportInput& input,
                             const std::string& digest) {
  survey::CertificateInput certified = words.certified;
  certified.issued = created_now();
  certified.digest = digest;
  const survey::ReportDocument document = survey::certificate_document(input.plan.deployment, certified);
  return words.certificate.ends_with(".md") ? survey::to_markdown(document) : survey::to_html(document, "");
}

int run(const ReportArgs& words, Session& session) {
  const int files_on_stdout =
      on_stdout(words.report) + (words.site_sheet == "-") + (words.certificate == "-");
  if (files_on_stdout + session.options.json > 1)
    return session.fail(
        {"error", "usage", kUsage,
         "only one of -o -, --site-sheet -, --certificate - and --json can have standard output", ""});
  if (files_on_stdout > 0) session.result_to_stderr();
  CommandFiles of_command{.inputs = words.runs, .outputs = words.report.paths, .run_outputs = {}};
  of_command.inputs.insert(of_command.inputs.end(), {words.saved, words.report.since});
  of_command.outputs.insert(of_command.outputs.end(), {words.site_sheet, words.certificate});
  if (auto fit = check_no_overwriting(of_command); !fit) return session.fail(fit.error());
  if (auto fit = check_report(words.report); !fit) return session.fail(fit.error());
  for (const std::string& file : {words.site_sheet, words.certificate})
    if (auto fit = check_output(file); !fit) return session.fail(fit.error());

  const auto text = io::read_document(words.saved);
  if (!text) return session.fail(text.error());
  auto input = read_saved(*text, words, session);
  if (!input) return session.fail(input.error());
  if (auto verified = verify_with(words.runs, *input, session); !verified)
    return session.fail(verified.error());
  if (interrupted()) return session.interrupted();
  if (auto added = add_changes(*input, words.report.since); !added) return session.fail(added.error());

  auto files = report_files(words.report, *input);
  if (!words.site_sheet.empty())
    files.push_back({words.site_sheet, survey::site_sheet_html(input->plan.deployment, digest_of(*text))});
  if (!words.certificate.empty()) {
    if (input->outcome != survey::Outcome::kCalibrated)
      return session.fail(Error{.code = Errc::kUsage,
                                .found = "--certificate of a calibration that exported nothing",
                                .expected = "a deployment, or the report of a calibration that has one"});
    files.push_back({words.certificate, certificate_page(words, *input, digest_of(*text))});
  }
  if (auto written = io::write_files(files); !written) return session.fail(written.error());
  session.result(changes_text(*input) + verdict_text(*input) + report_lines(words.report));
  if (!words.site_sheet.empty() && words.site_sheet != "-")
    session.result(fmt::format("{:<17}{}\n", "site sheet", words.site_sheet));
  if (!words.certificate.empty() && words.certificate != "-")
    session.result(fmt::format("{:<17}{}\n", "certificate", words.certificate));
  Json object = {{"verdict", verdict_json(*input)}};
  add_changes_json(*input, object);
  return session.finish(object);
}

}  // namespace

void add_report(CLI::App& app, CommonOptions& common, Action& action) {
  auto words = std::make_shared<ReportArgs>();
  CLI::App* command = add_command(app, common, "report", "Make a report or a site sheet from saved results",
                                  "octant report hall/deployment.json hall/heldout -o hall/report.html");
  command
      ->add_option("saved", words->saved,
                   "Deployment file, or what --report R.json kept (it knows more: residuals, weak "
                   "directions, the track)")
      ->required()
      ->type_name("SAVED.json");
  command->add_option("run", words->runs, "Run folders with truth.tum, to verify with")->type_name("RUN");
  command
      ->add_option("-o,--output,--report", words->report.paths,
                   "Report to write: .html, .md or .json; may be given several times")
      ->type_name("R")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_flag("--report-static", words->report.still,
                    "Pages without the interactive layer: no script, and small");
  command->add_option("--since", words->report.since, "Report what changed since this earlier deployment")
      ->type_name("OLD.json");
  command
      ->add_option("--site-sheet", words->site_sheet,
                   "Sheets to print: each beacon with coordinates, delay and a QR code")
      ->type_name("S.html");
  command
      ->add_option("--certificate", words->certificate,
                   "Calibration record with what ISO/IEC 17025 7.8 asks of one: .html or .md")
      ->type_name("C.html");
  const auto certified = [&](const char* name, std::string& value, const char* help) {
    command->add_option(name, value, help)->type_name("TEXT");
  };
  certified("--certificate-number", words->certified.number,
            "Its number; by default of the site and the digest");
  certified("--organisation", words->certified.organisation, "Who calibrated: name and address");
  certified("--operator", words->certified.operator_name, "Who did it");
  certified("--customer", words->certified.customer, "For whom");
  certified("--place", words->certified.place, "Where");
  command->callback(
      [words, &action] { action = [words](Session& session) { return run(*words, session); }; });
}

}  // namespace octant::app
