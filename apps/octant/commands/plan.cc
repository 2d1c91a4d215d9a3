// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/commands/plan.h"

#include "apps/octant/commands.h"

namespace octant::app {
namespace {

int run(const PlanArgs& args, Session& session) {
  const int asked =
      (args.beacons || args.tolerance_m ? 1 : 0) + (args.stations ? 1 : 0) + (args.schedule ? 1 : 0);
  const auto usage = [](const std::string& message) { fail_usage(message, "octant plan --help"); };
  if (asked == 0)
    usage("say what is to be planned: --beacons N or --tolerance M, --stations N, or --schedule");
  if (asked > 1) usage("one plan at a time: --beacons or --tolerance, --stations, --schedule");
  if (!args.stations && !args.runs.empty()) usage("recordings help with --stations alone");
  if (!(args.beacons || args.tolerance_m) && (!args.output.empty() || !args.report.empty()))
    usage("-o and --report go with --beacons or --tolerance");
  if (!args.stations && !args.csv.empty()) usage("--csv goes with --stations");
  if ((args.output == "-") + (args.report == "-") + (args.csv == "-") + session.options.json > 1)
    fail_usage("only one of -o -, --report -, --csv - and --json can have standard output");
  if (args.stations) return plan_stations(args, session);
  return args.schedule ? plan_schedule(args, session) : plan_beacons(args, session);
}

/// Options of the search for positions.
void add_search_options(CLI::App& command, PlanArgs& args) {
  add_option(command, "--algorithm", args.algorithm, "A",
             "NLopt's global one: crs2, direct, isres, esch or none")
      ->check(CLI::IsMember({"crs2", "direct", "isres", "esch", "none"}))
      ->capture_default_str();
  add_option(command, "--local", args.local, "A", "NLopt's local one: bobyqa, cobyla, sbplx or none")
      ->check(CLI::IsMember({"bobyqa", "cobyla", "sbplx", "none"}));
  add_option(command, "--evaluations", args.evaluations, "N",
             "Layouts that each run of an algorithm may look at; 0: by their number of unknowns")
      ->check(CLI::Range(0, 10'000'000))
      ->capture_default_str();
  add_option(command, "--restarts", args.restarts, "N",
             "Random layouts from which searches set out too; fewer are faster")
      ->check(CLI::Range(0, 10'000));
  add_option(command, "--proof", args.proof, "N",
             "Compare numbers of beacons up to this with greedy, regular and random layouts")
      ->check(CLI::Range(1, 200));
}

void add_beacon_options(CLI::App& command, PlanArgs& args) {
  const OptionGroup group(command, "Where to put beacons (a scene with floor_m and mounts)");
  add_option(command, "--beacons", args.beacons, "N", "So many beacons in all")->check(CLI::Range(1, 200));
  add_option(command, "--tolerance", args.tolerance_m, "M",
             "Instead: as few as keep the goal within this everywhere")
      ->check(CLI::PositiveNumber);
  add_option(command, "--coverage", args.coverage, "K",
             "Beacons that every place has to hear; else what a fix needs")
      ->check(CLI::Range(0, 100));
  add_option(command, "--most", args.most, "N", "With --tolerance: never more than these")
      ->check(CLI::Range(1, 200));
  command.add_flag("--keep", args.keep, "The site's beacons stay where they are; others are added");
  add_option(command, "--goal", args.goal, "G", "Expected error of a fix over the floor: worst, p95 or mean")
      ->check(CLI::IsMember({"worst", "p95", "mean"}));
  add_search_options(command, args);
  add_option(command, "--mount-sigma", args.mount_sigma_m, "M",
             "How well the beacons will stand where the plan says, for the written site")
      ->check(CLI::NonNegativeNumber);
  add_option(command, "-o,--output", args.output, "NEW_SITE.yaml",
             "Site file to write, with the new beacons; - is standard output");
  add_option(command, "--report", args.report, "R.html",
             "Page to write: plan of the hall, beacons, proof; - is standard output");
}

void add_station_options(CLI::App& command, PlanArgs& args) {
  const OptionGroup group(command, "Where to stop next for a good calibration");
  add_option(command, "--stations", args.stations, "N", "So many stops")->check(CLI::Range(1, 500));
  add_option(command, "run", args.runs, "RUN", "Recordings that are there already (with a site file)");
  add_option(command, "--criterion", args.criterion, "C",
             "Of the beacons' coordinates: a (sum of variances) or d (volume of the ellipsoid)")
      ->check(CLI::IsMember({"a", "d"}));
  add_option(command, "--grid", args.grid_m, "M",
             "Distance between the places tried; else by the floor's size")
      ->check(CLI::PositiveNumber);
  add_option(command, "--headings", args.headings, "N", "Headings tried at each place")
      ->check(CLI::Range(1, 360));
  add_option(command, "--clearance", args.clearance_m, "M",
             "Distance kept from the floor's edge and from obstacles")
      ->check(CLI::NonNegativeNumber);
  add_option(command, "--rounds", args.rounds, "N", "How often each beacon fires at a stop")
      ->check(CLI::Range(1, 100000));
  add_option(command, "--range", args.range_m, "M",
             "Beacons are heard so far; else as the scene or the recordings have it")
      ->check(CLI::PositiveNumber);
  add_option(command, "--hearing-angle", args.hearing_deg, "DEG", "Receivers with an axis hear so far off it")
      ->check(CLI::Range(1.0, 180.0));
  add_option(command, "--csv", args.csv, "F.csv", "Checklist to write; - is standard output");
}

void add_schedule_options(CLI::App& command, PlanArgs& args) {
  const OptionGroup group(command, "Which beacons may fire together, and how often");
  command.add_flag("--schedule", args.schedule, "Time between firings, groups, length of a cycle");
  add_option(command, "--height", args.height_m, "M",
             "Of the hall; else half a metre above the highest beacon")
      ->check(CLI::PositiveNumber);
  add_option(command, "--wall-reflection", args.wall_reflection, "R",
             "Share of the amplitude that a wall gives back")
      ->check(CLI::Range(0.0, 0.9999));
  add_option(command, "--pulse", args.pulse_s, "S", "Length of a pulse in seconds")
      ->check(CLI::PositiveNumber);
  command.add_flag("--trust-walls", args.trust_walls,
                   "Nothing is heard round walls and beams, echoes neither");
  command.add_flag("--by-time", args.by_time,
                   "Beacons heard together may fire together where they come at times that are apart");
}

}  // namespace

void add_plan(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<PlanArgs>(
      app, common, action, "plan",
      "Plan ahead: where to put beacons, where to stop for a calibration, who may fire together",
      "octant plan hall/site.yaml --stations 5 --range 12           a checklist of stops\n"
      "  octant plan hall/site.yaml hall/run --stations 3             the next ones after a recording\n"
      "  octant plan aisles/site.yaml --beacons 8 -o aisles/new.yaml  places for eight beacons\n"
      "  octant plan aisles/site.yaml --tolerance 0.02 --coverage 4   how many does it take?\n"
      "  octant plan aisles/site.yaml --schedule                      firing order and cycle",
      run);
  add_required_option(*command, "input", args->input, "SITE.yaml|DEPLOYMENT.json",
                      "Site file, or a deployment for stops and schedules");
  add_option(*command, "--scene", args->scene, "S.yaml",
             "Scene file: floor, walls, mounts, patterns; goes before the site's own scene block");
  add_option(*command, "--vehicle", args->vehicle, "ID", "Whose receivers hear; else the first vehicle's");
  add_beacon_options(*command, *args);
  add_station_options(*command, *args);
  add_schedule_options(*command, *args);
}

}  // namespace octant::app
