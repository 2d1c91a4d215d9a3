// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/steps.h"
#include "io/site/scenario_yaml.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"

namespace octant::app {
namespace {

struct SimulateArgs {
  std::string scenario, folder;
};

int run(const SimulateArgs& args, Session& session) {
  const std::string& folder = args.folder;
  check_no_overwriting(
      {.inputs = {args.scenario},
       .outputs = {folder + "/scenario.yaml", folder + "/site.yaml", folder + "/deployment.true.json"},
       .run_outputs = {folder + "/run", folder + "/heldout"}});
  const std::string text = need(io::read_document(args.scenario));
  const Scenario scenario = need(io::scenario_from_yaml(text, args.scenario));
  session.warn(scenario.warnings);
  const World world = simulated(scenario, session);
  write_world(args.folder, world, text);
  session.result(fmt::format(
      "{}: {} beacons, {} arrivals to calibrate with, {} held out, seed {}\nwritten          {}\n",
      world.site.name, world.site.beacons.size(), world.run.arrivals.size(), world.heldout.arrivals.size(),
      session.options.seed, args.folder));
  return session.finish({{"folder", args.folder},
                         {"beacons", world.site.beacons.size()},
                         {"arrivals", world.run.arrivals.size()},
                         {"heldout_arrivals", world.heldout.arrivals.size()},
                         {"seed", session.options.seed}});
}

}  // namespace

void add_simulate(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<SimulateArgs>(
      app, common, action, "simulate", "Simulate a world with known truth: site, recordings, true deployment",
      "octant simulate datasets/hall/scenario.yaml --seed 7 -o hall", run);
  add_required_option(*command, "scenario", args->scenario, "SCENARIO.yaml",
                      "Scenario file (octant schema scenario)");
  add_required_option(*command, "-o,--output", args->folder, "DIR",
                      "Folder to make; an older simulated world there is replaced");
}

}  // namespace octant::app
