// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

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

/// Positions in both deployments of the beacons that both determine.
std::vector<std::array<Eigen::Vector3d, 2>> common_places(const Deployment& before, const Deployment& now) {
  std::vector<std::array<Eigen::Vector3d, 2>> places;
  for (const DeploymentBeacon& a : before.beacons)
    for (const DeploymentBeacon& b : now.beacons)
      if (a.name == b.name && a.status != BeaconStatus::kUndetermined &&
          b.status != BeaconStatus::kUndetermined)
        places.push_back({a.position_m, b.position_m});
  return places;
}

/// Share of the distances between beacons that agree within some centimetres and percent. Distances do not
/// depend on the frame. No value for fewer than three beacons. By chance one in twenty distances agrees for
/// two different sites of equal size, and one in five for a site with half of its beacons moved.
std::optional<double> share_of_same_distances(const std::vector<std::array<Eigen::Vector3d, 2>>& places) {
  constexpr double kSame_m = 0.05, kSame = 0.02;
  std::size_t pairs = 0, same = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t j = i + 1; j < places.size(); ++j) {
      const double was = (places[i][0] - places[j][0]).norm(), is = (places[i][1] - places[j][1]).norm();
      same += std::abs(is - was) <= kSame_m + kSame * std::max(is, was) ? 1 : 0;
      ++pairs;
    }
  if (places.size() < 3) return std::nullopt;
  return static_cast<double>(same) / static_cast<double>(pairs);
}

/// Smallest shift of a beacon, if it is at least a hundred times the extent of the site.
std::optional<double> way_between_frames(const std::vector<std::array<Eigen::Vector3d, 2>>& places) {
  constexpr double kExtents = 100.0;
  double extent_m = 1.0, least_m = INFINITY;
  for (const auto& place : places) {
    least_m = std::min(least_m, (place[1] - place[0]).norm());
    for (const auto& other : places) extent_m = std::max(extent_m, (other[0] - place[0]).norm());
  }
  return std::isfinite(least_m) && least_m > kExtents * extent_m ? std::optional(least_m) : std::nullopt;
}

/// Warns if the deployments belong to different sites, whose differences are meaningless.
void warn_of_two_sites(const Deployment& before, const Deployment& now, Session& session) {
  constexpr double kTwoSites = 0.25;
  if (before.site != now.site)
    session.warn(
        fmt::format("these are deployments of '{}' and of '{}': are they one site?", before.site, now.site));
  const auto places = common_places(before, now);
  if (const auto way_m = way_between_frames(places))
    session.warn(
        fmt::format("the two maps lie {:.0f} m and more from each other, in frames of their own, it "
                    "seems: what is told beside that may be rounding; compare them in one frame",
                    *way_m));
  const auto share = share_of_same_distances(places);
  if (share && *share < kTwoSites)
    session.warn(
        fmt::format("{:.0f} % of the distances between beacons of the same name are the same: are these two "
                    "sites, or do "
                    "half of the beacons stand elsewhere now?",
                    100 * *share));
}

int run(const DiffArgs& args, Session& session) {
  const Deployment before = need(io::read_deployment(args.before)), now = need(io::read_deployment(args.now));
  const survey::Changes changes =
      survey::changes_between(before, now, stated_drift(before, now.created, args.drift));
  if (changes.beacons.empty())
    fail_with({.code = Errc::kBadInput,
               .file = args.now,
               .found = "no beacon in common with " + args.before,
               .expected = "two deployments of one site"});
  warn_of_two_sites(before, now, session);
  session.result(changes_text(changes));
  return session.finish({{"since", changes.since},
                         {"derived", is_derived(now, before)},
                         {"changes", io::json_of(changes.found)},
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
