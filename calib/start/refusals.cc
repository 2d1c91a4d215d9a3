// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/refusals.h"

#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

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

}  // namespace octant::calib
