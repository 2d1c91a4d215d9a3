// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Rejected arrivals by beacon: a beacon that lost most of its arrivals has changed, or is hidden.
#include <utility>

#include <fmt/format.h>

#include "apps/octant/steps/steps.h"
#include "apps/octant/text/layout.h"

namespace octant::app {

std::vector<LeftOutOfBeacon> left_out_by_beacon(const Deployment& deployment,
                                                const std::vector<MeasurementLog>& runs,
                                                const Localization& localization) {
  std::vector<LeftOutOfBeacon> beacons;
  for (const DeploymentBeacon& b : deployment.beacons) beacons.push_back({b.name});
  for (std::size_t r = 0; r < std::min(runs.size(), localization.run_ends.size()); ++r) {
    std::map<std::pair<std::int64_t, VehicleId>, std::vector<BeaconId>> heard;
    for (const Arrival& a : runs[r].arrivals)
      if (a.epoch != kNoEpoch) heard[{a.epoch, a.vehicle}].push_back(a.beacon);
    for (const Fix& fix : localization.of_run(r)) {
      const auto at = heard.find({fix.epoch, fix.vehicle});
      if (!fix.ok() || at == heard.end() || at->second.size() != fix.rejections.size()) continue;
      for (std::size_t i = 0; i < fix.rejections.size(); ++i) {
        const BeaconId beacon = at->second[i];
        if (!beacon.valid() || beacon.index() >= beacons.size()) continue;
        ++beacons[beacon.index()].heard;
        if (fix.rejections[i] != Rejection::kUsed && fix.rejections[i] != Rejection::kNotNeeded)
          ++beacons[beacon.index()].left_out;
      }
    }
  }
  return beacons;
}

std::string left_out_text(const std::vector<LeftOutOfBeacon>& beacons) {
  constexpr std::size_t kSome = 4;  // fewer rejections may be a few echoes
  std::string who;
  for (const LeftOutOfBeacon& b : beacons)
    if (b.left_out >= kSome && 2 * b.left_out > b.heard)
      who += fmt::format("{}{} of {} of {}", who.empty() ? "" : ", ", b.left_out, b.heard, b.name);
  if (who.empty()) return {};
  return named_line("next", "Inspect the beacons whose arrivals were left out: " + who +
                                ". octant monitor finds what changed.");
}

Json left_out_json(const std::vector<LeftOutOfBeacon>& beacons) {
  Json counts = Json::object();
  for (const LeftOutOfBeacon& b : beacons)
    if (b.left_out > 0) counts[b.name] = b.left_out;
  return {{"arrivals", {{"by_beacon", counts}}}};
}

}  // namespace octant::app
