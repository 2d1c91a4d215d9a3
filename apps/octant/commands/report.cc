// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0

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

struct ReportCommandArgs {
  std::string saved;
  std::vector<std::string> runs;
  ReportArgs report;
  std::string site_sheet;
  std::string certificate;
  survey::CertificateInput certified;
};

/// Digest stored in the file; for a file without one, the digest of its bytes.
std::string digest_of(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_object() && json.contains("digest") && json["digest"].is_string()) return json["digest"];
  return io::sha256_hex(text);
}

/// Content of a saved report, or of a report made from a deployment and its geometry.
survey::ReportInput read_saved(const std::string& text, const ReportCommandArgs& args, Session& session) {
  if (is_saved_report(text)) {
    survey::ReportInput saved = need(report_from_json(text, args.saved));
    saved.command = session.command_line;
    return saved;
  }
  survey::ReportInput input = report_input(need(io::deployment_from_json(text, args.saved)), session);
  survey::add_geometry(input, session.threads());
  return input;
}

void verify_with(const std::vector<std::string>& folders, survey::ReportInput& input, Session& session) {
  if (folders.empty()) return;
  const Deployment& d = input.plan.deployment;
  if (input.outcome != survey::Outcome::kCalibrated)
    fail_with({.code = Errc::kUsage,
               .found = "runs beside the report of a calibration that exported nothing",
               .expected = "a report or a deployment that has beacons"});
  const auto runs = read_runs(folders, d, {.read_truth = true, .read_poses = false}, session);
  const Localization found = need(localize_runs(d, runs, Method::kAuto));
  add_verification(input, found, verify_fixes(d, runs, found));
}

/// Markdown if the file name asks for it, else a page without a script.
std::string certificate_page(const ReportCommandArgs& args, const survey::ReportInput& input,
                             const std::string& digest) {
  survey::CertificateInput certified = args.certified;
  certified.issued = created_now();
  certified.digest = digest;
  const survey::ReportDocument document = survey::certificate_document(input.plan.deployment, certified);
  return args.certificate.ends_with(".md") ? survey::to_markdown(document) : survey::to_html(document, "");
}

int run(const ReportCommandArgs& args, Session& session) {
  std::vector<OutputOption> outputs = {{"-o", ""}};
  for (const std::string& path : args.report.paths) outputs.push_back({"-o", path});
  outputs.insert(outputs.end(), {{"--site-sheet", args.site_sheet}, {"--certificate", args.certificate}});
  check_outputs(with_files(args.runs, {args.saved, args.report.since}), outputs, session);
  check_report(args.report);

  const std::string text = need(io::read_document(args.saved));
  survey::ReportInput input = read_saved(text, args, session);
  verify_with(args.runs, input, session);
  stop_if_interrupted();
  add_changes(input, args.report.since);

  auto files = report_files(args.report, input);
  if (!args.site_sheet.empty())
    files.push_back({args.site_sheet, survey::site_sheet_html(input.plan.deployment, digest_of(text))});
  if (!args.certificate.empty()) {
    if (input.outcome != survey::Outcome::kCalibrated)
      fail_with({.code = Errc::kUsage,
                 .found = "--certificate of a calibration that exported nothing",
                 .expected = "a deployment, or the report of a calibration that has one"});
    files.push_back({args.certificate, certificate_page(args, input, digest_of(text))});
  }
  need(io::write_files(files));
  session.result(changes_text(input) + verdict_text(input) + report_lines(args.report));
  if (!args.site_sheet.empty() && args.site_sheet != "-")
    session.result(fmt::format("{:<17}{}\n", "site sheet", args.site_sheet));
  if (!args.certificate.empty() && args.certificate != "-")
    session.result(fmt::format("{:<17}{}\n", "certificate", args.certificate));
  Json object = {{"verdict", verdict_json(input)}};
  add_changes_json(input, object);
  return session.finish(object);
}

}  // namespace

void add_report(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<ReportCommandArgs>(
      app, common, action, "report", "Make a report or a site sheet from saved results",
      "octant report hall/deployment.json hall/heldout -o hall/report.html", run);
  add_required_option(*command, "saved", args->saved, "SAVED.json",
                      "Deployment file, or what --report R.json kept (it knows more: residuals, weak "
                      "directions, the track)");
  add_option(*command, "run", args->runs, "RUN", "Run folders with truth.tum, to verify with");
  add_option(*command, "-o,--output,--report", args->report.paths, "R",
             "Report to write: .html, .md or .json; may be given several times")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_flag("--report-static", args->report.still,
                    "Pages without the interactive layer: no script, and small");
  add_option(*command, "--since", args->report.since, "OLD.json",
             "Report what changed since this earlier deployment");
  add_option(*command, "--site-sheet", args->site_sheet, "S.html",
             "Sheets to print: each beacon with coordinates, delay and a QR code");
  add_option(*command, "--certificate", args->certificate, "C.html",
             "Calibration record with what ISO/IEC 17025 7.8 asks of one: .html or .md");
  add_option(*command, "--certificate-number", args->certified.number, "TEXT",
             "Its number; by default of the site and the digest");
  add_option(*command, "--organisation", args->certified.organisation, "TEXT",
             "Who calibrated: name and address");
  add_option(*command, "--operator", args->certified.operator_name, "TEXT", "Who did it");
  add_option(*command, "--customer", args->certified.customer, "TEXT", "For whom");
  add_option(*command, "--place", args->certified.place, "TEXT", "Where");
}

}  // namespace octant::app
