// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/site_beacons.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "io/yaml/yaml_reader.h"
#include "io/yaml/yaml_writer.h"

namespace octant::io {
namespace {

/// Rounded to a tenth of a millimetre, finer than anchors can be mounted.
std::string number(double value) { return fmt::format("{:.4f}", std::round(value * 1e4) / 1e4 + 0.0); }

void write_point(YamlWriter& out, const Eigen::Vector3d& p) {
  out.begin_list(true);
  for (int i = 0; i < 3; ++i) out.text(number(p[i]));
  out.end_list();
}

void write_beacon(YamlWriter& out, const SiteBeaconEntry& b) {
  out.begin_map(true);
  out.text("id"), out.text(b.name, yaml_text(b.name) != b.name);
  out.text("position_m"), write_point(out, b.position_m);
  out.text("sigma_m"), out.text(number(b.sigma_m));
  out.end_map();
}

void write_axis(YamlWriter& out, const SiteBeaconEntry& b) {
  out.begin_map(true);
  out.text("id"), out.text(b.name, yaml_text(b.name) != b.name);
  out.text("axis"), write_point(out, *b.axis);
  out.end_map();
}

/// A site file's document with other beacons.
class BeaconsInPlace {
 public:
  BeaconsInPlace(const YamlNode& root, const std::vector<SiteBeaconEntry>& beacons, bool keep)
      : root_(root), beacons_(beacons), keep_(keep) {}

  std::string text(std::vector<std::string>& warnings) {
    out_.begin_map(false);
    for (std::size_t i = 0; i < root_.size(); ++i) {
      const std::string_view key = root_.key(i).scalar();
      if (key == "control" && !keep_) {
        warnings.emplace_back(
            "control distances were between beacons that the plan does not keep, and are left out");
        continue;
      }
      out_.copy(root_.key(i));
      if (key == "beacons")
        write_beacons(root_.value(i));
      else if (key == "scene" && root_.value(i).is_map())
        write_scene(root_.value(i));
      else
        out_.copy(root_.value(i));
    }
    out_.end_map();
    return out_.finish();
  }

 private:
  void write_kept(const YamlNode& list) {
    out_.begin_list(false);
    if (!keep_ || !list.is_sequence()) return;
    for (std::size_t i = 0; i < list.size(); ++i) out_.copy(list.item(i));
  }

  void write_beacons(const YamlNode& list) {
    write_kept(list);
    for (const SiteBeaconEntry& b : beacons_) write_beacon(out_, b);
    out_.end_list();
  }

  void write_axes(const YamlNode& list) {
    write_kept(list);
    for (const SiteBeaconEntry& b : beacons_)
      if (b.axis) write_axis(out_, b);
    out_.end_list();
  }

  void write_scene(const YamlNode& scene) {
    bool written = false;
    out_.begin_map(false);
    for (std::size_t i = 0; i < scene.size(); ++i) {
      out_.copy(scene.key(i));
      const bool here = scene.key(i).scalar() == "beacons";
      here ? write_axes(scene.value(i)) : out_.copy(scene.value(i));
      written = written || here;
    }
    const bool any =
        std::ranges::any_of(beacons_, [](const SiteBeaconEntry& b) { return b.axis.has_value(); });
    if (any && !written) out_.text("beacons"), write_axes({});
    out_.end_map();
  }

  YamlWriter out_;
  const YamlNode& root_;
  const std::vector<SiteBeaconEntry>& beacons_;
  bool keep_;
};

}  // namespace

Result<SiteBeaconsText> with_beacons(std::string_view site_yaml, const std::string& path,
                                     const std::vector<SiteBeaconEntry>& beacons, bool keep) {
  auto root = parse_yaml(site_yaml, path);
  if (!root) return fail(root.error());
  if (auto old = site_from_yaml(*root, path); !old) return fail(old.error());
  SiteBeaconsText result;
  result.text = fmt::format("# Written by octant plan from {}\n{}", path,
                            BeaconsInPlace(*root, beacons, keep).text(result.warnings));
  const auto again = parse_yaml(result.text, path);
  if (!again) return fail(again.error());
  if (auto site = site_from_yaml(*again, path); !site) return fail(site.error());
  return result;
}

}  // namespace octant::io
