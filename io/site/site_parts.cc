// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <fmt/format.h>

#include "io/site/site_id.h"
#include "io/site/site_parts.h"

namespace octant::io {

std::string UniqueIds::take(YamlMap& map, const std::string& otherwise) {
  const bool named = map.has("id") || otherwise.empty();
  std::string id = named ? map.required_text("id") : otherwise;
  if (log_.error) return id;
  const YamlNode given = map.get("id"), node = named ? given : map.node();
  if (!is_site_id(id)) {
    log_.fail(node, fmt::format("{} is {}", map.path("id"), in_quotes(id)),
              "a name of up to 200 characters on one line");
  }
  const auto [first, is_new] = lines_.emplace(id, node.line());
  if (!is_new) {
    log_.fail(node,
              fmt::format("{} id {} is used twice (first in line {})", kind_, in_quotes(id), first->second),
              "each id once", "rename one of them");
  }
  return id;
}

Coordinates read_coordinates(const YamlNode& node, const std::string& name, NumberRange range, YamlLog& log) {
  Coordinates values;
  const std::vector<YamlNode> items = list_of(node, name, log, 3);
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!items[i].is_null()) values[i] = number_of(items[i], fmt::format("{}[{}]", name, i), log, range);
  }
  return values;
}

std::optional<Eigen::Vector3d> read_axis(YamlMap& map, const char* example, YamlLog& log) {
  const std::vector<double> numbers = map.numbers("axis", 3);
  if (numbers.size() != 3 || log.error) return std::nullopt;
  const Eigen::Vector3d axis(numbers[0], numbers[1], numbers[2]);
  const double norm = axis.norm();
  if (!(norm > 1e-9) || !std::isfinite(norm)) {
    map.fail("axis", map.path("axis") + " has no length", fmt::format("a direction, such as {}", example));
    return std::nullopt;
  }
  // A vector that is of unit length to the last digits is left alone, so that a written file reads back the
  // same.
  return std::abs(norm - 1.0) < 1e-14 ? axis : Eigen::Vector3d(axis / norm);
}

Coordinates read_sigmas(const YamlNode& node, const std::string& name, YamlLog& log) {
  if (!node.is_defined()) return {};
  if (node.is_sequence()) return read_coordinates(node, name, kNotNegative, log);
  const double sigma = number_of(node, name, log, kNotNegative);
  return {sigma, sigma, sigma};
}

namespace {

/// delay_s and delay_sigma_s of one beacon, in place of timing's.
void read_own_delay(YamlMap& map, const Timing& timing, SiteBeacon& beacon, YamlLog& log) {
  beacon.delay_s = map.optional_number("delay_s");
  beacon.delay_sigma_s = map.optional_number("delay_sigma_s", kNotNegative);
  if (log.error || timing.delay_per.beacon || (!beacon.delay_s && !beacon.delay_sigma_s)) return;
  const char* key = beacon.delay_s ? "delay_s" : "delay_sigma_s";
  map.fail(key, fmt::format("{} of a beacon, and timing.delay_per has no 'beacon'", map.path(key)),
           "delay_per: beacon, or a list with beacon",
           "without it beacons have no delays of their own: state it, or take the line out");
}

}  // namespace

void read_beacons(YamlMap& root, Site& site, YamlLog& log) {
  if (!root.has("beacons"))
    root.fail_missing("beacons", "a list of beacons (beacons: [] where there are none)");
  UniqueIds ids("beacon", log);
  root.each("beacons", site.beacons, [&](YamlMap& map, SiteBeacon& beacon) {
    beacon.name = ids.take(map);
    if (const YamlNode at = map.block("position_m"); at.is_defined()) {
      beacon.position_m = read_coordinates(at, map.path("position_m"), kAnyNumber, log);
    }
    beacon.sigma_m = read_sigmas(map.block("sigma_m"), map.path("sigma_m"), log);
    read_own_delay(map, site.timing, beacon, log);
    map.get("clock");  // clocks/clock_yaml.cc
  });
}

}  // namespace octant::io
