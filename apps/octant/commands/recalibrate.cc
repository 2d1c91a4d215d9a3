// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/reporting.h"
#include "apps/octant/steps/revisiting.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/text/changes_text.h"
#include "calib/revisit/finished.h"
#include "io/deployment/deployment_json.h"
#include "io/text/atomic_file.h"

namespace octant::app {
namespace {

struct RecalibrateArgs {
  std::string deployment, output;
  std::vector<std::string> runs;
  ReportArgs report;
  DriftArgs drift;
};

calib::Provenance provenance_of(const SecondVisitFiles& visit, const Session& session) {
  return {created_now(), OCTANT_VERSION, session.command_line, visit.inputs};
}

/// Writes deployment and reports, all or none.
void write_recalibration(const RecalibrateArgs& args, const Deployment& deployment,
                         const survey::ReportInput& input) {
  auto files = report_files(args.report, input);
  files.push_back({args.output, need(io::checked_deployment_json(args.output, deployment))});
  need(io::write_files(files));
}

int run(const RecalibrateArgs& args, Session& session) {
  check_outputs(with_files(args.runs, {args.deployment}), report_outputs(args.report, {{"-o", args.output}}),
                session);
  check_report(args.report);
  const SecondVisitFiles visit = revisit_files(args.deployment, args.runs, args.drift, session);
  Json object = revisit_json(visit, session);
  if (const auto failure = failure_of(visit.revisit)) return session.fail(*failure, object);

  const Deployment now = calib::finished(visit.revisit, visit.before, provenance_of(visit, session));
  survey::ReportInput input = report_input(now, session);
  input.changes = survey::changes_between(visit.before, now);
  input.changes->found = visit.revisit.comparison.changes;
  input.changes->silent = visit.revisit.silent;
  input.changes->not_observed = visit.revisit.not_observed;
  if (!args.report.paths.empty()) survey::add_geometry(input, session.threads());
  add_deployment_json(now, object);
  object["verdict"] = verdict_json(input);
  write_recalibration(args, now, input);
  session.result(verdict_text(input) + "\n" + revisit_text(visit));
  if (args.output != "-") session.result(fmt::format("{:<17}{}\n", "deployment", args.output));
  session.result(report_lines(args.report));
  return session.finish(object);
}

}  // namespace

void add_recalibrate(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<RecalibrateArgs>(
      app, common, action, "recalibrate",
      "Update a calibration by a second visit: what changed is found and told anew, all else is carried over",
      "octant recalibrate hall/deployment.json hall/autumn -o hall/autumn.json", run);
  add_required_option(*command, "deployment", args->deployment, "DEPLOYMENT.json", "The earlier deployment");
  add_required_option(*command, "run", args->runs, "RUN",
                      "Run folders of the second visit; a few stops or minutes do");
  add_required_option(*command, "-o,--output", args->output, "NEW.json",
                      "Deployment file to write; - is standard output");
  add_report_options(*command, args->report, false);
  add_drift_options(*command, args->drift);
}

}  // namespace octant::app
