// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/live/follow.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/method_options.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/steps/validity_words.h"
#include "apps/octant/text/layout.h"
#include "io/run/tum.h"
#include "io/text/atomic_file.h"

namespace octant::app {
namespace {

struct LocalizeArgs {
  std::string deployment, output, csv, trusted_key;
  std::vector<std::string> runs;
  MethodArgs how;
  FollowArgs live;
};

/// Writes both files, or neither if one of them fails.
void write_outputs(const LocalizeArgs& args, const Deployment& deployment, const std::vector<Fix>& fixes) {
  if (!args.csv.empty()) need(io::write_file(args.csv, io::fixes_to_csv(fixes, names_of(deployment))));
  const auto written = io::write_file(args.output, io::fixes_to_tum(fixes));
  if (!written && !args.csv.empty() && args.csv != "-") std::remove(args.csv.c_str());
  need(written);
}

void warn_of_no_fix(const Deployment& deployment, const std::vector<MeasurementLog>& runs,
                    const Localization& found, Session& session) {
  const bool pose_by_pose = found.method == to_string(Method::kLeastSquares);
  session.warn(fmt::format("There is not a single fix: {}.", why_no_fix(found)));
  for (const MeasurementLog& run : runs)
    for (const std::string& doubt : doubts_about(deployment, run, pose_by_pose))
      session.warn(fmt::format("{}: {}", run.path, doubt));
}

void warn_of_fixes(const LocalizeArgs& args, const Localization& found, Session& session) {
  const std::vector<Fix>& fixes = found.fixes;
  const auto another = [&](const Fix& fix) { return fix.vehicle != fixes.front().vehicle; };
  if (args.output != "-" && std::ranges::any_of(fixes, another))
    session.warn("TUM names no vehicle, and there are fixes of several: tell them apart by --csv");
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    if (fixes[i].ok() && fixes[i - 1].ok() && fixes[i].time_s < fixes[i - 1].time_s) {
      session.warn(
          "the recordings or vehicles overlap in time, so the rows of the TUM file do not increase; localize "
          "them one by one");
      return;
    }
  }
}

std::string fixes_text(const Localization& found) {
  const std::string why = found.no_fix_reasons.empty() ? "" : ": " + counts_in_words(found.no_fix_reasons);
  return fmt::format("{:<17}{} ({}{}), {} times no fix{}\n{:<17}{} used, {} left out\n", "fixes", found.ok,
                     found.method, found.why.empty() ? "" : ": " + found.why, found.no_fix, why, "arrivals",
                     found.arrivals, found.rejected);
}

/// Live localization needs a deployment only.
int run_live(const LocalizeArgs& args, Session& session) {
  FollowArgs live = args.live;
  const bool names_format = std::ranges::count(kLiveFormats, args.output) > 0;
  if (names_format) live.format = args.output;
  if (!args.runs.empty() || !args.csv.empty() || session.options.json ||
      (!args.output.empty() && args.output != "-" && !names_format))
    fail_usage("--follow takes lines (--from) instead of runs, and its fixes go to standard output",
               "leave RUN, -o (except for a format: json, nmea, ros, mavlink), --csv and --json out");
  return follow(live, args.deployment, args.trusted_key, args.how.method, session);
}

int run(const LocalizeArgs& args, Session& session) {
  if (args.live.follow) return run_live(args, session);
  if (args.runs.empty() || args.output.empty())
    fail_usage(args.runs.empty() ? "RUN is required (run folders: the recordings)" : "--output is required",
               "octant localize --help explains; --follow localizes as the data come");
  check_outputs(with_files(args.runs, {args.deployment, args.trusted_key, args.how.map}),
                {{"-o", args.output}, {"--csv", args.csv}}, session);
  const Deployment deployment = need(read_trusted_deployment(args.deployment, args.trusted_key));
  warn_if_contradicted(deployment, args.deployment, session);
  warn_if_overdue(deployment, session);
  const auto runs = read_runs(args.runs, deployment,
                              {.read_truth = false, .read_poses = looks_at_poses(args.how)}, session);
  const Localization found =
      need(localize_runs(deployment, runs, args.how.method, method_input(args.how, deployment)));
  stop_if_interrupted();
  if (found.ok == 0) warn_of_no_fix(deployment, runs, found, session);
  warn_of_fixes(args, found, session);
  warn_outside_validity(deployment, runs, found, session);
  write_outputs(args, deployment, found.fixes);

  const auto left_out = left_out_by_beacon(deployment, runs, found);
  session.result(fixes_text(found) + integrity_text(found) + left_out_text(left_out));
  for (const std::string& file : {args.output, args.csv})
    if (!file.empty() && file != "-") session.result(fmt::format("{:<17}{}\n", "written", file));
  return session.finish({{"status", found.ok > 0 ? "ok" : "no_fix"},
                         {"method", found.method},
                         {"why", found.why},
                         {"fixes", found.ok},
                         {"no_fix", found.no_fix},
                         {"seconds", session.seconds()},
                         {"arrivals", found.arrivals},
                         {"rejected", found.rejected},
                         {"left_out", left_out_json(left_out)},
                         {"no_fix_reasons", no_fix_json(found)},
                         {"integrity", integrity_json(found)},
                         {"assumed_temperature_degC", assumed_temperature_json(deployment, found, runs)},
                         {"speeds", speeds_json(found, runs)},
                         {"calibration", calibration_age_json(deployment)}});
}

}  // namespace

void add_localize(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<LocalizeArgs>(
      app, common, action, "localize", "Tell where the vehicle was",
      "octant localize hall/deployment.json hall/heldout -o hall/fixes.tum --csv hall/fixes.csv", run);
  add_required_option(*command, "deployment", args->deployment, "DEPLOYMENT.json",
                      "Deployment file, from calibrate");
  add_option(*command, "run", args->runs, "RUN", "Run folders: the recordings");
  add_option(*command, "-o,--output", args->output, "FIXES.tum",
             "Fixes to write, TUM format; - is standard output");
  add_option(*command, "--csv", args->csv, "F.csv", "Fixes with sigmas and reasons to write");
  add_method_options(*command, args->how);
  add_trust_option(*command, args->trusted_key);
  add_follow_options(*command, args->live);
}

}  // namespace octant::app
