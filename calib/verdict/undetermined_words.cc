// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/undetermined_words.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace octant::calib {
namespace {

/// Beacons described in one sentence.
struct BeaconGroup {
  std::vector<std::string> names;
  std::string why, remedy;
  double least_m = 0.0, most_m = 0.0;
};

std::vector<BeaconGroup> groups_of(const std::vector<UndeterminedBeacon>& beacons) {
  std::vector<BeaconGroup> groups;
  for (const UndeterminedBeacon& b : beacons) {
    const bool known = b.sigma_m > 0 && b.sigma_m < kNothingM;
    const auto alike = [&](const BeaconGroup& g) {
      return g.remedy == b.remedy && (known ? g.most_m > 0 : g.why == b.why);
    };
    auto at = std::ranges::find_if(groups, alike);
    if (at == groups.end())
      at = groups.insert(at, {{}, b.why, b.remedy, known ? b.sigma_m : 0.0, known ? b.sigma_m : 0.0});
    at->names.push_back(b.beacon);
    if (!known) continue;
    at->least_m = std::min(at->least_m, b.sigma_m);
    at->most_m = std::max(at->most_m, b.sigma_m);
  }
  return groups;
}

std::string reason_of(const BeaconGroup& group, double limit_m) {
  constexpr std::string_view kIt = "it was ";
  if (group.names.size() > 1 && group.why.starts_with(kIt))
    return "they were " + group.why.substr(kIt.size());
  if (group.names.size() == 1 || group.most_m == 0.0) return group.why;
  const std::string least = length_in_words(group.least_m), most = length_in_words(group.most_m);
  return fmt::format("their {} are known to {} only, the tolerance is {}",
                     group.why.starts_with("its height") ? "heights" : "positions",
                     least == most ? most : least + " to " + most, length_in_words(limit_m));
}

}  // namespace

std::string length_in_words(double length_m) {
  return length_m < 1.0         ? fmt::format("{:.0f} mm", 1000 * length_m)
         : length_m < kNothingM ? fmt::format("{:.2f} m", length_m)
                                : "nothing";
}

std::vector<std::string> in_groups(const std::vector<UndeterminedBeacon>& beacons, double limit_m) {
  std::vector<std::string> texts;
  for (const BeaconGroup& g : groups_of(beacons))
    texts.push_back(fmt::format("beacon{} {} ({})", g.names.size() == 1 ? "" : "s", fmt::join(g.names, ", "),
                                reason_of(g, limit_m)));
  return texts;
}

std::vector<std::string> warnings_of(const std::vector<UndeterminedBeacon>& beacons, double limit_m) {
  std::vector<std::string> warnings;
  for (const BeaconGroup& g : groups_of(beacons))
    warnings.push_back(
        g.names.size() == 1
            ? fmt::format("beacon {} is undetermined: {}; {}", g.names.front(), g.why, g.remedy)
            : fmt::format("{} beacons are undetermined: {} ({}); {}", g.names.size(),
                          fmt::join(g.names, ", "), reason_of(g, limit_m), g.remedy));
  return warnings;
}

}  // namespace octant::calib
