// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/steps/revisiting.h"
#include "apps/octant/steps/validity_words.h"
#include "apps/octant/text/changes_text.h"

namespace octant::app {
namespace {

struct MonitorArgs {
  std::string deployment;
  std::vector<std::string> runs;
  DriftArgs drift;
};

int run(const MonitorArgs& args, Session& session) {
  const SecondVisitFiles visit = revisit_files(args.deployment, args.runs, args.drift, session);
  Json object = visit.head;
  object.update(revisit_json(visit, session));
  object["calibration"] = calibration_age_json(visit.before);
  warn_if_overdue(visit.before, session);
  if (const auto failure = failure_of(visit.revisit)) return session.fail(*failure, object);
  session.result(revisit_text(visit) + due_line(visit.before));
  std::vector<std::string> changes, remedies;
  for (const Change& c : visit.revisit.comparison.changes) {
    if (!needs_action(c, visit.revisit.medium)) continue;
    changes.push_back(in_words(c));
    remedies.push_back(remedy_of(c));
  }
  for (const Silence& silent : visit.revisit.silent) {
    changes.push_back(in_words(silent));
    remedies.push_back(fmt::format("inspect {} on site", silent.subject));
  }
  object["action"] = !changes.empty();
  if (changes.empty()) return session.finish(object);
  return session.fail({"changed", "changed", kGateFailed, fmt::format("{}", fmt::join(changes, "; ")),
                       fmt::format("{}", fmt::join(remedies, "; "))},
                      object);
}

}  // namespace

void add_monitor(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] =
      add_command<MonitorArgs>(app, common, action, "monitor",
                               "Ask an ordinary recording whether the calibration still holds: which "
                               "beacon, receiver or speed no longer fits (exit 6)",
                               "octant monitor hall/deployment.json hall/night", run);
  add_required_option(*command, "deployment", args->deployment, "DEPLOYMENT.json",
                      "Deployment file, from calibrate or recalibrate");
  add_required_option(*command, "run", args->runs, "RUN", "Run folders; no reference trajectory is needed");
  add_drift_options(*command, args->drift);
}

}  // namespace octant::app
