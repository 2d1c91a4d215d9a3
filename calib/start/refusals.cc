// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/refusals.h"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/start/mirror_images.h"

namespace octant::calib {

Solution interrupted_solution() {
  Solution solution;
  solution.status = SolveStatus::kInterrupted;
  solution.message = "interrupted";
  return solution;
}

Solution refused(WeakDirection direction) {
  Solution solution;
  solution.status = SolveStatus::kUndetermined;
  solution.message = fmt::format("the data do not determine {}; nothing is exported. To settle it: {}",
                                 direction.description, direction.remedy);
  solution.undetermined = direction.parameters;
  solution.weak.push_back(std::move(direction));
  return solution;
}

namespace {

struct PlacedArrivals {
  std::size_t placed = 0, all = 0;
  bool any_state = false;  ///< of bearings too
};
PlacedArrivals placed_of(const std::vector<Trajectory>& trajectories) {
  PlacedArrivals n;
  for (const Trajectory& t : trajectories) {
    n.all += t.arrivals.size() + t.stateless_arrivals.size();
    for (const ArrivalObservation& a : t.arrivals) n.placed += t.nodes[a.node].placed ? 1 : 0;
    for (const Segment& s : t.segments) n.any_state = n.any_state || t.nodes[s.first_node].placed;
  }
  return n;
}

bool are_all_held(const Site& site) {
  return std::all_of(site.beacons.begin(), site.beacons.end(),
                     [](const SiteBeacon& b) { return b.is_control_point(); });
}

Solution without_any_pose(const Problem& problem, const std::vector<bool>& beacon_found) {
  WeakDirection direction;
  const NameTable site_names = names_of(problem.site);
  std::vector<std::string> names;
  for (std::size_t b = 0; b < beacon_found.size(); ++b) {
    if (beacon_found[b]) continue;
    direction.parameters.push_back(owner_name(parameters::beacon_delay(b), site_names));
    names.push_back(problem.site.beacons[b].name);
  }
  if (names.empty()) {
    // All beacons are known and still no pose came of them: too few are heard together.
    for (std::size_t b = 0; b < problem.site.beacons.size(); ++b)
      direction.parameters.push_back(owner_name(parameters::beacon_delay(b), site_names));
    names = site_names.beacons;
    direction.description =
        fmt::format("any pose of the vehicle from beacons {}: no epoch hears enough of them at once",
                    fmt::join(names, ", "));
  } else {
    direction.description = fmt::format("any pose of the vehicle, and with it the positions of beacons {}",
                                        fmt::join(names, ", "));
  }
  direction.remedy =
      "give approximate positions of three beacons that do not stand in line with the path, or measured "
      "poses of the vehicle";
  direction.blocking = true;
  return refused(std::move(direction));
}

/// Beacons that all stand in a line: no pose is told from its image in it.
Solution without_a_side(const Problem& problem, const PlacedArrivals& n) {
  WeakDirection direction;
  const NameTable site_names = names_of(problem.site);
  for (std::size_t b = 0; b < problem.site.beacons.size(); ++b)
    direction.parameters.push_back(owner_name(parameters::beacon_delay(b), site_names));
  direction.description = fmt::format(
      "the poses of the vehicle ({} of {} arrivals have none): beacons {} stand in one line, and the image "
      "of "
      "each pose in it explains the arrivals as well",
      n.all - n.placed, n.all, fmt::join(site_names.beacons, ", "));
  direction.remedy =
      "add a beacon beside that line, record odometry or poses of the vehicle, or use receivers that tell "
      "left "
      "from right";
  direction.blocking = true;
  return refused(std::move(direction));
}

}  // namespace

std::optional<Solution> without_poses(const Problem& problem, const ParameterLayout& layout,
                                      const std::vector<bool>& beacon_found,
                                      const std::vector<Trajectory>& trajectories, double least_share) {
  const PlacedArrivals n = placed_of(trajectories);
  const bool are_few = static_cast<double>(n.placed) < least_share * static_cast<double>(n.all);
  const bool all_held = are_all_held(problem.site);
  if (n.any_state && !(are_few && all_held)) return std::nullopt;
  if (all_held && is_known_in_line(problem, layout, trajectories)) return without_a_side(problem, n);
  return without_any_pose(problem, beacon_found);
}

}  // namespace octant::calib
