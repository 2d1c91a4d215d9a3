// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <map>

#include "io/clocks/clock_files.h"
#include "io/yaml/yaml_reader.h"

namespace octant::io {

Result<ClockModel> read_clock_model(const std::string& site_path, const Site& site) {
  const auto node = read_yaml(site_path);
  if (!node) return fail(node.error());
  YamlLog log(site_path);
  YamlMap root(*node, "", log);
  YamlMap timing(root.block("timing"), "timing", log);
  ClockModel model;
  model.is_free = timing.text("clock", "") == "free";
  const double usual = timing.choice<double>(
      "oscillator", {{"crystal", kCrystalDeviation}, {"tcxo", kTcxoDeviation}}, model.allan_deviation);
  model.allan_deviation = timing.number("allan_deviation", usual, kPositive);
  std::map<std::string, int> number;
  const auto add = [&](const std::string& name) {
    const auto [it, is_new] = number.try_emplace(name, static_cast<int>(model.names.size()));
    if (is_new) model.names.push_back(name);
    model.of_device.push_back(it->second);
  };
  const std::vector<YamlNode> beacons = root.list("beacons");
  for (std::size_t b = 0; b < site.beacons.size(); ++b) {
    const std::string& id = site.beacons[b].name;
    add(b < beacons.size() ? YamlMap(beacons[b], "beacons", log).text("clock", id) : id);
  }
  for (const SiteReceiver& r : site.receivers) add(site.vehicles[r.vehicle.index()].name + " (vehicle)");
  if (log.error) return fail(*log.error);
  return model;
}

}  // namespace octant::io
