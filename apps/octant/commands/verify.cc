// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/method_options.h"
#include "apps/octant/steps/reporting.h"
#include "apps/octant/steps/validity_words.h"
#include "apps/octant/text/changes_text.h"
#include "apps/octant/text/layout.h"

namespace octant::app {
namespace {

struct VerifyArgs {
  std::string deployment, trusted_key;
  std::vector<std::string> runs;
  ReportArgs report;
  MethodArgs how;
  bool all_methods = false;
};

std::string gates_in_words(const survey::Evaluation& evaluation, const Localization& found) {
  std::string missed;
  for (const auto& gate : evaluation.gates) {
    if (gate.pass) continue;
    if (!missed.empty()) missed += "; ";
    missed += gate.name == "matched" ? unmatched_text(found)
                                     : fmt::format("{}: {} is beyond the limit of {}", gate.name,
                                                   length_text(gate.value), length_text(gate.limit));
  }
  return missed;
}

/// Prints one row for each method: its errors, or the reason why it is not applicable.
int compare(const Deployment& deployment, const std::vector<MeasurementLog>& runs, const MethodInput& input,
            Session& session) {
  Table table{
      "lrrrrrrrr",
      {{"method", "fixes", "no fix", "RMSE [mm]", "95 %", "largest", "heading [mrad]", "NEES", "us a fix"}}};
  Json rows = Json::array();
  std::string not_possible;
  for (const auto& [name, method] : method_names()) {
    if (method == Method::kAuto) continue;
    stop_if_interrupted();
    const auto began = std::chrono::steady_clock::now();
    const auto found = localize_runs(deployment, runs, method, input);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    if (!found) {
      rows.push_back({{"method", name}, {"possible", false}, {"reason", found.error().message()}});
      not_possible +=
          fmt::format("{:<17}{}; expected {}\n", name, found.error().found, found.error().expected);
      continue;
    }
    const survey::Evaluation e = verify_fixes(deployment, runs, *found);
    const double each_us =
        1e6 * seconds / static_cast<double>(std::max<std::size_t>(1, found->ok + found->no_fix));
    Json row = evaluation_json(e);
    row.erase("gates");
    row.erase("runs");
    row.erase("floors");
    row.update({{"method", name}, {"possible", true}, {"seconds_per_fix", 1e-6 * each_us}});
    rows.push_back(std::move(row));
    const auto figure = [&](double value) {
      return e.matched > 0 ? fmt::format("{:.1f}", value) : std::string("-");
    };
    table.rows.push_back(
        {std::string(name), fmt::format("{}", found->ok), fmt::format("{}", found->no_fix),
         figure(1e3 * e.position_rmse_m), figure(1e3 * e.position_p95_m), figure(1e3 * e.max_error_m),
         e.heading_rmse_rad ? figure(1e3 * *e.heading_rmse_rad) : "-",
         e.nees_mean ? fmt::format("{:.2f}", *e.nees_mean) : "-", fmt::format("{:.0f}", each_us)});
  }
  session.result(table.text() + (not_possible.empty() ? "" : "\nnot possible here:\n" + not_possible));
  return session.finish({{"status", "ok"}, {"methods", rows}});
}

Json located_json(const Deployment& deployment, const std::vector<MeasurementLog>& runs,
                  const Localization& found, const std::vector<LeftOutOfBeacon>& left_out) {
  return {{"no_fix_reasons", no_fix_json(found)},
          {"left_out", left_out_json(left_out)},
          {"calibration_runs", runs_of_calibration(deployment, runs)},
          {"speeds", speeds_json(found, runs)},
          {"calibration", calibration_age_json(deployment)}};
}

int run(const VerifyArgs& args, Session& session) {
  if (args.all_methods && !args.report.paths.empty()) fail_usage("--all-methods is a table without a report");
  check_outputs(with_files(args.runs, {args.deployment, args.trusted_key, args.how.map, args.report.since}),
                report_outputs(args.report), session);
  check_report(args.report);
  const Deployment deployment = need(read_trusted_deployment(args.deployment, args.trusted_key));
  warn_if_contradicted(deployment, args.deployment, session);
  warn_if_overdue(deployment, session);
  const auto runs =
      read_runs(args.runs, deployment, {.read_truth = true, .read_poses = looks_at_poses(args.how)}, session);
  check_truth(runs);  // before the long computation
  const MethodInput input = method_input(args.how, deployment);
  if (args.all_methods) return compare(deployment, runs, input, session);
  const Localization found = need(localize_runs(deployment, runs, args.how.method, input));
  stop_if_interrupted();
  warn_outside_validity(deployment, runs, found, session);
  for (const std::string& run : runs_of_calibration(deployment, runs))
    session.warn(fmt::format(
        "{} took part in the calibration (the digests of its data are among the deployment's inputs), so "
        "its errors are smaller than those of new recordings. Verify with a recording that did not.",
        run));
  const survey::Evaluation evaluation = verify_fixes(deployment, runs, found);
  if (const std::string doubt = doubt_of_sigmas(evaluation, deployment.motion); !doubt.empty())
    session.warn(doubt);

  survey::ReportInput report = report_input(deployment, session);
  report.kind = "Verification";
  add_verification(report, found, evaluation);
  add_changes(report, args.report.since);
  if (!args.report.paths.empty()) survey::add_geometry(report, session.threads());
  need(io::write_files(report_files(args.report, report)));
  const auto left_out = left_out_by_beacon(deployment, runs, found);
  session.result(evaluation_text(evaluation, found) + left_out_text(left_out) + due_line(deployment) +
                 changes_text(report) + report_lines(args.report));
  Json object = result_head("verification", args.deployment, deployment, runs);
  object.update(evaluation_json(evaluation));
  object.update(located_json(deployment, runs, found, left_out));
  add_changes_json(report, object);
  if (!evaluation.pass())
    return session.fail({"gate_failed", "gate_failed", kGateFailed, gates_in_words(evaluation, found), ""},
                        object);
  return session.finish(object);
}

}  // namespace

void add_verify(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<VerifyArgs>(
      app, common, action, "verify",
      "Localize held-out recordings and hold the fixes against truth.tum and the tolerance",
      "octant verify hall/deployment.json hall/heldout", run);
  add_required_option(*command, "deployment", args->deployment, "DEPLOYMENT.json",
                      "Deployment file, from calibrate");
  add_required_option(*command, "run", args->runs, "RUN", "Run folders with truth.tum");
  command->add_flag("--all-methods", args->all_methods,
                    "Compare all methods on these runs, as a table; no gates");
  add_method_options(*command, args->how);
  add_trust_option(*command, args->trusted_key);
  add_report_options(*command, args->report, true);
}

}  // namespace octant::app
