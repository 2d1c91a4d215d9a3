// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <memory>

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

Result<World> make_world(const SimulateArgs& args, Session& session, std::string& text) {
  const ExitAtOnce nothing_written_yet;
  auto read = io::read_document(args.scenario);
  if (!read) return fail(read.error());
  text = *read;
  auto scenario = io::scenario_from_yaml(text, args.scenario);
  if (!scenario) return fail(scenario.error());
  session.warn(scenario->warnings);
  return simulate(*scenario, session.options.seed);
}

int run(const SimulateArgs& args, Session& session) {
  const std::string& folder = args.folder;
  if (auto fit = check_no_overwriting(
          {.inputs = {args.scenario},
           .outputs = {folder + "/scenario.yaml", folder + "/site.yaml", folder + "/deployment.true.json"},
           .run_outputs = {folder + "/run", folder + "/heldout"}});
      !fit)
    return session.fail(fit.error());
  std::string text;
  auto world = make_world(args, session, text);
  if (!world) return session.fail(world.error());
  world->truth.created = created_now();
  world->truth.program_version = OCTANT_VERSION;
  world->truth.program_command = session.command_line;
  if (auto written = write_world(args.folder, *world, text); !written) return session.fail(written.error());
  session.result(fmt::format(
      "{}: {} beacons, {} arrivals to calibrate with, {} held out, seed {}\nwritten          {}\n",
      world->site.name, world->site.beacons.size(), world->run.arrivals.size(),
      world->heldout.arrivals.size(), session.options.seed, args.folder));
  return session.finish({{"folder", args.folder},
                         {"beacons", world->site.beacons.size()},
                         {"arrivals", world->run.arrivals.size()},
                         {"heldout_arrivals", world->heldout.arrivals.size()},
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
