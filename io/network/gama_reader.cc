// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "io/network/gama_parts.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"

namespace octant::io {
namespace {

/// Orientation of the axes, and the sense of angles relative to them.
void read_axes(const pugi::xml_node& network, NetworkFile& file, XmlLog& log) {
  const std::string axes = network.attribute("axes-xy") ? XmlLog::text(network, "axes-xy") : "ne";
  const std::string angles = network.attribute("angles") ? XmlLog::text(network, "angles") : "left-handed";
  if (std::ranges::count(kSurveyAxes, axes) == 0)
    return log.fail(network, fmt::format("axes-xy={}", in_quotes(axes)), "ne, sw, es, wn, en, nw, se or ws");
  if (angles != "left-handed" && angles != "right-handed")
    return log.fail(network, fmt::format("angles={}", in_quotes(angles)), "left-handed or right-handed");
  set_axes(file, axes, angles == "left-handed");
}

void read_parameters(const pugi::xml_node& node, NetworkFile& file, XmlLog& log) {
  file.sigma_unit = log.number(node, "sigma-apr", kPositive).value_or(file.sigma_unit);
  const std::string actual = XmlLog::text(node, "sigma-act");
  if (!actual.empty() && actual != "apriori" && actual != "aposteriori")
    log.fail(node, fmt::format("sigma-act={}", in_quotes(actual)), "apriori or aposteriori");
  if (!actual.empty()) file.sigmas_a_posteriori = actual == "aposteriori";
  if (const auto limit_mm = log.number(node, "tol-abs", kPositive)) file.outlier_limit_m = 1e-3 * *limit_mm;
  file.datum_follows = XmlLog::text(node, "update-constrained-coordinates") == "yes";
}

void read_content(const pugi::xml_node& content, GamaObservations& observations, XmlLog& log) {
  observations.read_sigmas(content);
  for (const pugi::xml_node& node : content.children()) {
    if (node.type() != pugi::node_element || log.error) continue;
    const std::string_view name = node.name();
    if (name == "point")
      observations.read_point(node);
    else if (name == "obs" || name == "height-differences" || name == "vectors" || name == "coordinates")
      observations.read_cluster(node);
    else
      log.fail(node, fmt::format("<{}>", name),
               "<point>, <obs>, <height-differences>, <vectors> or <coordinates>");
  }
}

void check_fixed(const pugi::xml_node& network, const NetworkFile& file, XmlLog& log) {
  for (const NetworkPoint& point : file.network.points)
    for (std::size_t i = 0; i < 3; ++i)
      if (point.role[i] == CoordinateRole::kFixed && !point.known[i])
        log.fail(network, fmt::format("fixed point {} without {}", in_quotes(point.id), "xyz"[i]),
                 "a coordinate");
}

/// Sections of <network>, which may be repeated and in any order.
void read_network(const pugi::xml_node& network, NetworkFile& file, XmlLog& log) {
  read_axes(network, file, log);
  for (const pugi::xml_node& node : network.children("description"))
    file.description += without_blanks(node.text().get());
  for (const pugi::xml_node& node : network.children("parameters")) read_parameters(node, file, log);
  GamaObservations observations(file, log);
  for (const pugi::xml_node& node : network.children("points-observations"))
    read_content(node, observations, log);
  check_fixed(network, file, log);
}

}  // namespace

Result<NetworkFile> parse_gama(const std::string& bytes, const std::string& path) {
  const Result<std::string> text = xml_as_utf8(bytes, path);
  if (!text) return fail(text.error());
  XmlLog log(path, *text);
  pugi::xml_document document;
  log.parse(document, "gama-local.dtd");
  if (log.error) return fail(*log.error);
  const pugi::xml_node root =
      document.child("gama-local") ? document.child("gama-local") : document.child("gama-xml");
  const pugi::xml_node network = root.child("network");
  if (!network.child("points-observations"))
    log.fail(document.document_element(), "no <gama-local> with <network> and <points-observations>",
             "a gama-local document (.gkf)");
  NetworkFile file;
  if (!log.error) read_network(network, file, log);
  if (log.error) return fail(*log.error);
  return file;
}

Result<NetworkFile> read_gama(const std::string& path) {
  const Result<std::string> bytes = read_file(path, kLargestYaml);
  if (!bytes) return fail(bytes.error());
  return parse_gama(*bytes, path);
}

}  // namespace octant::io
