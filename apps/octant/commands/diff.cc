// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/steps/revisiting.h"
#include "apps/octant/text/changes_text.h"
#include "io/deployment/deployment_json.h"
#include "survey/changes.h"

namespace octant::app {
namespace {

struct DiffArgs {
  std::string before, now;
  DriftArgs drift;
};

Json rows_json(const survey::Changes& changes) {
  Json rows = Json::array();
  for (const survey::BeaconChange& c : changes.beacons) {
    rows.push_back({{"id", c.name},
                    {"shift_m", c.shift_m},
                    {"sigma_m", c.sigma_m},
                    {"p", c.p},
                    {"delay_change_s", c.delay_change_s},
                    {"delay_sigma_s", c.delay_sigma_s},
                    {"delay_p", c.delay_p}});
  }
  return rows;
}

int run(const DiffArgs& args, Session& session) {
  const auto before = io::read_deployment(args.before);
  if (!before) return session.fail(before.error());
  const auto now = io::read_deployment(args.now);
  if (!now) return session.fail(now.error());
  const survey::Changes changes =
      survey::changes_between(*before, *now, drift_between(before->created, now->created, args.drift));
  if (changes.beacons.empty())
    return session.fail(Error{.code = Errc::kBadInput,
                              .file = args.now,
                              .found = "no beacon that " + args.before + " has too",
                              .expected = "two deployments of one site"});
  session.result(changes_text(changes));
  return session.finish({{"since", changes.since},
                         {"derived", is_derived(*now, *before)},
                         {"changes", changes_json(changes.found)},
                         {"beacons", rows_json(changes)},
                         {"gone", changes.gone},
                         {"added", changes.added},
                         {"same_datum", changes.same_datum},
                         {"doubted_control_points", changes.doubted_control_points},
                         {"speed_change_mps", changes.speed_change_mps},
                         {"speed_sigma_mps", changes.speed_sigma_mps}});
}

}  // namespace

void add_diff(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<DiffArgs>(
      app, common, action, "diff",
      "What changed between two deployments of a site, and whether it is more than chance",
      "octant diff hall/spring.json hall/autumn.json", run);
  add_required_option(*command, "before", args->before, "A.json", "The earlier deployment");
  add_required_option(*command, "now", args->now, "B.json", "The later deployment");
  add_drift_options(*command, args->drift);
}

}  // namespace octant::app
