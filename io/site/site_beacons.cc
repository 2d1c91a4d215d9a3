// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/site_beacons.h"

#include <cmath>

#include <fmt/format.h>

#include "io/text/yaml_reader.h"
#include "io/text/yaml_text.h"

namespace octant::io {
namespace {

/// To a tenth of a millimetre: nobody drills finer.
std::string number(double value) { return fmt::format("{:.4f}", std::round(value * 1e4) / 1e4 + 0.0); }

YAML::Node flow(const std::vector<std::string>& items) {
  YAML::Node list(YAML::NodeType::Sequence);
  list.SetStyle(YAML::EmitterStyle::Flow);
  for (const std::string& item : items) list.push_back(item);
  return list;
}

YAML::Node beacon_node(const SiteBeaconEntry& b) {
  YAML::Node node(YAML::NodeType::Map);
  node.SetStyle(YAML::EmitterStyle::Flow);
  node["id"] = b.name;
  node["position_m"] = flow({number(b.position_m.x()), number(b.position_m.y()), number(b.position_m.z())});
  node["sigma_m"] = number(b.sigma_m);
  return node;
}

YAML::Node axis_node(const SiteBeaconEntry& b) {
  YAML::Node node(YAML::NodeType::Map);
  node.SetStyle(YAML::EmitterStyle::Flow);
  node["id"] = b.name;
  node["axis"] = flow({number(b.axis->x()), number(b.axis->y()), number(b.axis->z())});
  return node;
}

void replace(YAML::Node owner, const std::vector<YAML::Node>& entries, bool keep) {
  YAML::Node list = keep && owner["beacons"] && owner["beacons"].IsSequence()
                        ? owner["beacons"]
                        : YAML::Node(YAML::NodeType::Sequence);
  for (const YAML::Node& entry : entries) list.push_back(entry);
  list.SetStyle(YAML::EmitterStyle::Block);
  owner["beacons"] = list;
}

}  // namespace

Result<SiteBeaconsText> with_beacons(std::string_view site_yaml, const std::string& path,
                                     const std::vector<SiteBeaconEntry>& beacons, bool keep) {
  auto root = parse_yaml(site_yaml, path);
  if (!root) return fail(root.error());
  if (auto old = site_from_yaml(*root, path); !old) return fail(old.error());
  SiteBeaconsText out;
  std::vector<YAML::Node> entries, axes;
  for (const SiteBeaconEntry& b : beacons) {
    entries.push_back(beacon_node(b));
    if (b.axis) axes.push_back(axis_node(b));
  }
  replace(*root, entries, keep);
  if (!keep && (*root)["control"]) {
    root->remove("control");
    out.warnings.push_back(
        "control distances were between beacons that the plan does not keep, and are left out");
  }
  if (YAML::Node scene = (*root)["scene"];
      scene && scene.IsMap() && (!axes.empty() || (!keep && scene["beacons"])))
    replace(scene, axes, keep);
  YAML::Emitter emitter;
  emitter << *root;
  out.text = fmt::format("# Written by octant plan from {}\n{}\n", path, emitter.c_str());
  const auto again = parse_yaml(out.text, path);
  if (!again) return fail(again.error());
  if (auto site = site_from_yaml(*again, path); !site) return fail(site.error());
  return out;
}

}  // namespace octant::io
