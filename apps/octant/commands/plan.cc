// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/commands/plan.h"

#include <memory>

#include "apps/octant/commands.h"

namespace octant::app {
namespace {

int run(const PlanWords& words, Session& session) {
  const int asked =
      (words.beacons || words.tolerance_m ? 1 : 0) + (words.stations ? 1 : 0) + (words.schedule ? 1 : 0);
  const auto usage = [&](const std::string& message, const std::string& advice = "octant plan --help") {
    return session.fail({"error", "usage", kUsage, message, advice});
  };
  if (asked == 0)
    return usage("say what is to be planned: --beacons N or --tolerance M, --stations N, or --schedule");
  if (asked > 1) return usage("one plan at a time: --beacons or --tolerance, --stations, --schedule");
  if (!words.stations && !words.runs.empty()) return usage("recordings help with --stations alone");
  if (!(words.beacons || words.tolerance_m) && (!words.output.empty() || !words.report.empty()))
    return usage("-o and --report go with --beacons or --tolerance");
  if (!words.stations && !words.csv.empty()) return usage("--csv goes with --stations");
  if ((words.output == "-") + (words.report == "-") + (words.csv == "-") + session.options.json > 1)
    return usage("only one of -o -, --report -, --csv - and --json can have standard output", "");
  if (words.stations) return plan_stations(words, session);
  return words.schedule ? plan_schedule(words, session) : plan_beacons(words, session);
}

/// How the places are searched.
void add_search_options(CLI::App& command, PlanWords& words, const std::string& group) {
  command.add_option("--algorithm", words.algorithm, "NLopt's global one: crs2, direct, isres, esch or none")
      ->check(CLI::IsMember({"crs2", "direct", "isres", "esch", "none"}))
      ->capture_default_str()
      ->type_name("A")
      ->group(group);
  command.add_option("--local", words.local, "NLopt's local one: bobyqa, cobyla, sbplx or none")
      ->check(CLI::IsMember({"bobyqa", "cobyla", "sbplx", "none"}))
      ->capture_default_str()
      ->type_name("A")
      ->group(group);
  command
      .add_option("--evaluations", words.evaluations,
                  "Layouts that each run of an algorithm may look at; 0: by their number of unknowns")
      ->check(CLI::Range(0, 10'000'000))
      ->capture_default_str()
      ->type_name("N")
      ->group(group);
  command
      .add_option("--restarts", words.restarts,
                  "Random layouts from which searches set out too; fewer are faster")
      ->check(CLI::Range(0, 10'000))
      ->capture_default_str()
      ->type_name("N")
      ->group(group);
  command
      .add_option("--proof", words.proof,
                  "Compare numbers of beacons up to this with greedy, regular and random layouts")
      ->check(CLI::Range(1, 200))
      ->type_name("N")
      ->group(group);
}

void add_beacon_options(CLI::App& command, PlanWords& words) {
  const std::string group = "Where to put beacons (a scene with floor_m and mounts)";
  command.add_option("--beacons", words.beacons, "So many beacons in all")
      ->check(CLI::Range(1, 200))
      ->type_name("N")
      ->group(group);
  command
      .add_option("--tolerance", words.tolerance_m, "Instead: as few as keep the goal within this everywhere")
      ->check(CLI::PositiveNumber)
      ->type_name("M")
      ->group(group);
  command
      .add_option("--coverage", words.coverage, "Beacons that every place has to hear; else what a fix needs")
      ->check(CLI::Range(0, 100))
      ->type_name("K")
      ->group(group);
  command.add_option("--most", words.most, "With --tolerance: never more than these")
      ->check(CLI::Range(1, 200))
      ->capture_default_str()
      ->type_name("N")
      ->group(group);
  command.add_flag("--keep", words.keep, "The site's beacons stay where they are; others are added")
      ->group(group);
  command.add_option("--goal", words.goal, "Expected error of a fix over the floor: worst, p95 or mean")
      ->check(CLI::IsMember({"worst", "p95", "mean"}))
      ->capture_default_str()
      ->type_name("G")
      ->group(group);
  add_search_options(command, words, group);
  command
      .add_option("--mount-sigma", words.mount_sigma_m,
                  "How well the beacons will stand where the plan says, for the written site")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str()
      ->type_name("M")
      ->group(group);
  command
      .add_option("-o,--output", words.output,
                  "Site file to write, with the new beacons; - is standard output")
      ->type_name("NEW_SITE.yaml")
      ->group(group);
  command
      .add_option("--report", words.report,
                  "Page to write: plan of the hall, beacons, proof; - is standard output")
      ->type_name("R.html")
      ->group(group);
}

void add_station_options(CLI::App& command, PlanWords& words) {
  const std::string group = "Where to stop next for a good calibration";
  command.add_option("--stations", words.stations, "So many stops")
      ->check(CLI::Range(1, 500))
      ->type_name("N")
      ->group(group);
  command.add_option("run", words.runs, "Recordings that are there already (with a site file)")
      ->type_name("RUN")
      ->group(group);
  command
      .add_option("--criterion", words.criterion,
                  "Of the beacons' coordinates: a (sum of variances) or d (volume of the ellipsoid)")
      ->check(CLI::IsMember({"a", "d"}))
      ->capture_default_str()
      ->type_name("C")
      ->group(group);
  command.add_option("--grid", words.grid_m, "Distance between the places tried; else by the floor's size")
      ->check(CLI::PositiveNumber)
      ->type_name("M")
      ->group(group);
  command.add_option("--headings", words.headings, "Headings tried at each place")
      ->check(CLI::Range(1, 360))
      ->capture_default_str()
      ->type_name("N")
      ->group(group);
  command
      .add_option("--clearance", words.clearance_m, "Distance kept from the floor's edge and from obstacles")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str()
      ->type_name("M")
      ->group(group);
  command.add_option("--rounds", words.rounds, "How often each beacon fires at a stop")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str()
      ->type_name("N")
      ->group(group);
  command
      .add_option("--range", words.range_m,
                  "Beacons are heard so far; else as the scene or the recordings have it")
      ->check(CLI::PositiveNumber)
      ->type_name("M")
      ->group(group);
  command.add_option("--hearing-angle", words.hearing_deg, "Receivers with an axis hear so far off it")
      ->check(CLI::Range(1.0, 180.0))
      ->type_name("DEG")
      ->group(group);
  command.add_option("--csv", words.csv, "Checklist to write; - is standard output")
      ->type_name("F.csv")
      ->group(group);
}

void add_schedule_options(CLI::App& command, PlanWords& words) {
  const std::string group = "Which beacons may fire together, and how often";
  command.add_flag("--schedule", words.schedule, "Time between firings, groups, length of a cycle")
      ->group(group);
  command.add_option("--height", words.height_m, "Of the hall; else half a metre above the highest beacon")
      ->check(CLI::PositiveNumber)
      ->type_name("M")
      ->group(group);
  command
      .add_option("--wall-reflection", words.wall_reflection, "Share of the amplitude that a wall gives back")
      ->check(CLI::Range(0.0, 0.9999))
      ->capture_default_str()
      ->type_name("R")
      ->group(group);
  command.add_option("--pulse", words.pulse_s, "Length of a pulse in seconds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->type_name("S")
      ->group(group);
  command
      .add_flag("--trust-walls", words.trust_walls, "Nothing is heard round walls and beams, echoes neither")
      ->group(group);
  command
      .add_flag("--by-time", words.by_time,
                "Beacons heard together may fire together where they come at times that are apart")
      ->group(group);
}

}  // namespace

void add_plan(CLI::App& app, CommonOptions& common, Action& action) {
  auto words = std::make_shared<PlanWords>();
  CLI::App* command = add_command(
      app, common, "plan",
      "Plan ahead: where to put beacons, where to stop for a calibration, who may fire together",
      "octant plan hall/site.yaml --stations 5 --range 12           a checklist of stops\n"
      "  octant plan hall/site.yaml hall/run --stations 3             the next ones after a recording\n"
      "  octant plan aisles/site.yaml --beacons 8 -o aisles/new.yaml  places for eight beacons\n"
      "  octant plan aisles/site.yaml --tolerance 0.02 --coverage 4   how many does it take?\n"
      "  octant plan aisles/site.yaml --schedule                      firing order and cycle");
  command->add_option("input", words->input, "Site file, or a deployment for stops and schedules")
      ->required()
      ->type_name("SITE.yaml|DEPLOYMENT.json");
  command
      ->add_option("--scene", words->scene,
                   "Scene file: floor, walls, mounts, patterns; goes before the site's own scene block")
      ->type_name("S.yaml");
  command->add_option("--vehicle", words->vehicle, "Whose receivers hear; else the first vehicle's")
      ->type_name("ID");
  add_beacon_options(*command, *words);
  add_station_options(*command, *words);
  add_schedule_options(*command, *words);
  command->callback(
      [words, &action] { action = [words](Session& session) { return run(*words, session); }; });
}

}  // namespace octant::app
