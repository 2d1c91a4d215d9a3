// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "io/network/gama_parts.h"

namespace octant::io {

int GamaObservations::point(const pugi::xml_node& node, const std::string& id) {
  if (id.empty()) log_.fail(node, fmt::format("<{}> without the id of a point", node.name()), "an id");
  const auto [at, added] = index_.emplace(id, static_cast<int>(file_.network.points.size()));
  if (added) file_.network.points.push_back({.id = id, .known = {false, false, false}});
  return at->second;
}

int GamaObservations::end_point(const pugi::xml_node& node, const char* attribute) {
  if (!node.attribute(attribute))
    log_.fail(node, fmt::format("<{}> without '{}'", node.name(), attribute), "the id of a point");
  return point(node, XmlLog::text(node, attribute));
}

void GamaObservations::read_sigmas(const pugi::xml_node& node) {
  sigmas_ = {};
  for (const auto& [attribute, element] : {std::pair{"direction-stdev", "direction"},
                                           {"angle-stdev", "angle"},
                                           {"zenith-angle-stdev", "z-angle"},
                                           {"azimuth-stdev", "azimuth"}})
    if (const auto sigma = log_.number(node, attribute, kPositive)) sigmas_.angular[element] = *sigma;
  if (!node.attribute("distance-stdev")) return;
  const std::vector<double> abc = log_.numbers(node, node.attribute("distance-stdev").value());
  if (abc.empty() || abc.size() > 3 || !std::ranges::all_of(abc, [](double v) { return v >= 0.0; }))
    log_.fail(node, "distance-stdev of <points-observations>", "one to three numbers that are not negative");
  sigmas_.distance = {0.0, 0.0, 1.0};
  std::copy_n(abc.begin(), std::min<std::size_t>(abc.size(), 3), sigmas_.distance.begin());
}

/// Capital letters of adj= are coordinates that define the datum.
void GamaObservations::read_point(const pugi::xml_node& node) {
  constexpr std::array kNames = {"x", "y", "z"};
  NetworkPoint& p = file_.network.points[static_cast<std::size_t>(point(node, XmlLog::text(node, "id")))];
  const NetworkPoint before = p;
  for (std::size_t i = 0; i < 3; ++i)
    if (const auto value = log_.number(node, kNames[i])) {
      p.p_map_m[static_cast<int>(i)] = *value;
      p.known[i] = true;
    }
  for (const char* attribute : {"adj", "fix"})
    for (const char c : XmlLog::text(node, attribute)) {
      const int axis = std::tolower(static_cast<unsigned char>(c)) - 'x';
      if (axis < 0 || axis > 2)
        return log_.fail(node, fmt::format("{}={}", attribute, in_quotes(XmlLog::text(node, attribute))),
                         "letters out of x, y, z, X, Y, Z");
      p.role[static_cast<std::size_t>(axis)] = attribute[0] == 'f' ? CoordinateRole::kFixed
                                               : std::isupper(static_cast<unsigned char>(c)) != 0
                                                   ? CoordinateRole::kDatum
                                                   : CoordinateRole::kFree;
    }
  // Two elements of a point may complement each other, but not differ.
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<int>(i);
    if ((before.known[i] && p.p_map_m[axis] != before.p_map_m[axis]) ||
        (before.role[i] != CoordinateRole::kAbsent && p.role[i] != before.role[i]))
      return log_.fail(node, fmt::format("another {} of point {}", kNames[i], in_quotes(p.id)),
                       "one <point> for each id");
  }
}

}  // namespace octant::io
