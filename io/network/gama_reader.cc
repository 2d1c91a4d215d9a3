// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <numbers>
#include <set>
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
  const std::set<std::string> clockwise = {"ne", "sw", "es", "wn"};
  const std::set<std::string> counterclockwise = {"en", "nw", "se", "ws"};
  if (!clockwise.contains(axes) && !counterclockwise.contains(axes))
    return log.fail(network, fmt::format("axes-xy={}", in_quotes(axes)), "ne, sw, es, wn, en, nw, se or ws");
  if (angles != "left-handed" && angles != "right-handed")
    return log.fail(network, fmt::format("angles={}", in_quotes(angles)), "left-handed or right-handed");
  file.angle_sign = clockwise.contains(axes) == (angles == "left-handed") ? 1.0 : -1.0;
  file.north_rad = axes[0] == 'n'   ? 0.0
                   : axes[0] == 's' ? std::numbers::pi
                   : axes[1] == 'n' ? 0.5 * std::numbers::pi
                                    : -0.5 * std::numbers::pi;
}

void read_parameters(const pugi::xml_node& node, NetworkFile& file, XmlLog& log) {
  file.sigma_unit = log.number(node, "sigma-apr", kPositive).value_or(file.sigma_unit);
  const std::string actual = XmlLog::text(node, "sigma-act");
  if (!actual.empty() && actual != "apriori" && actual != "aposteriori")
    log.fail(node, fmt::format("sigma-act={}", in_quotes(actual)), "apriori or aposteriori");
  file.sigmas_a_posteriori = actual != "apriori";
}

GamaSigmas read_sigmas(const pugi::xml_node& node, XmlLog& log) {
  GamaSigmas sigmas;
  for (const auto& [attribute, element] : {std::pair{"direction-stdev", "direction"},
                                           {"angle-stdev", "angle"},
                                           {"zenith-angle-stdev", "z-angle"},
                                           {"azimuth-stdev", "azimuth"}})
    if (const auto sigma = log.number(node, attribute, kPositive)) sigmas.angular[element] = *sigma;
  if (!node.attribute("distance-stdev")) return sigmas;
  const std::vector<double> abc = log.numbers(node, node.attribute("distance-stdev").value());
  if (abc.empty() || abc.size() > 3 || !std::ranges::all_of(abc, [](double v) { return v >= 0.0; }))
    log.fail(node, "distance-stdev of <points-observations>", "one to three numbers that are not negative");
  sigmas.distance = {0.0, 0.0, 1.0};
  std::copy_n(abc.begin(), std::min<std::size_t>(abc.size(), 3), sigmas.distance.begin());
  return sigmas;
}

/// Capital letters of adj= are coordinates that define the datum.
void read_point(const pugi::xml_node& node, NetworkPoint& point, XmlLog& log) {
  constexpr std::array kNames = {"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i)
    if (const auto value = log.number(node, kNames[i])) {
      point.p_map_m[static_cast<int>(i)] = *value;
      point.known[i] = true;
    }
  for (const char* attribute : {"fix", "adj"})
    for (const char c : XmlLog::text(node, attribute)) {
      const int axis = std::tolower(static_cast<unsigned char>(c)) - 'x';
      if (axis < 0 || axis > 2)
        return log.fail(node, fmt::format("{}={}", attribute, in_quotes(XmlLog::text(node, attribute))),
                        "letters out of x, y, z, X, Y, Z");
      CoordinateRole& role = point.role[static_cast<std::size_t>(axis)];
      role = attribute[0] == 'f'                                ? CoordinateRole::kFixed
             : std::isupper(static_cast<unsigned char>(c)) != 0 ? CoordinateRole::kDatum
                                                                : CoordinateRole::kFree;
    }
  for (std::size_t i = 0; i < 3; ++i)
    if (point.role[i] == CoordinateRole::kFixed && !point.known[i])
      log.fail(node, fmt::format("fixed point {} without {}", in_quotes(point.id), kNames[i]),
               "a coordinate");
}

void read_content(const pugi::xml_node& content, NetworkFile& file, XmlLog& log) {
  GamaObservations observations(file, log, read_sigmas(content, log));
  for (const pugi::xml_node& node : content.children()) {
    if (node.type() != pugi::node_element || log.error) continue;
    const std::string_view name = node.name();
    if (name == "point") {
      const int index = observations.point(node, XmlLog::text(node, "id"));
      read_point(node, file.network.points[static_cast<std::size_t>(index)], log);
    } else if (name == "obs" || name == "height-differences" || name == "vectors" || name == "coordinates") {
      observations.read_cluster(node);
    } else {
      log.fail(node, fmt::format("<{}>", name),
               "<point>, <obs>, <height-differences>, <vectors> or <coordinates>");
    }
  }
}

bool has_role(const Network& network, int point, std::size_t axis) {
  return point < 0 || network.points[static_cast<std::size_t>(point)].role[axis] != CoordinateRole::kAbsent;
}

/// True if all points have the coordinates that the observation depends on.
bool is_usable(const Network& network, const SurveyObservation& o) {
  std::array<bool, 3> needs{};
  switch (o.kind) {
    case SurveyKind::kHeightDifference: needs = {false, false, true}; break;
    case SurveyKind::kZenithAngle:
    case SurveyKind::kSlopeDistance: needs = {true, true, true}; break;
    case SurveyKind::kX:
    case SurveyKind::kDx: needs[0] = true; break;
    case SurveyKind::kY:
    case SurveyKind::kDy: needs[1] = true; break;
    case SurveyKind::kZ:
    case SurveyKind::kDz: needs[2] = true; break;
    default: needs = {true, true, false};
  }
  for (std::size_t i = 0; i < 3; ++i)
    for (const int point : {o.from, o.to, o.second})
      if (needs[i] && !has_role(network, point, i)) return false;
  return true;
}

}  // namespace

void leave_out_unused(NetworkFile& file) {
  Network& network = file.network;
  std::vector<int> index(network.observations.size(), -1);
  std::vector<SurveyObservation> kept;
  std::set<int> sets;
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (!is_usable(network, network.observations[i])) continue;
    index[i] = static_cast<int>(kept.size());
    kept.push_back(network.observations[i]);
    if (kept.back().set >= 0) sets.insert(kept.back().set);
  }
  if (const std::size_t left_out = index.size() - kept.size(); left_out > 0)
    file.warnings.push_back(fmt::format(
        "{} observations are left out because a point of theirs is neither fixed nor adjusted", left_out));
  for (SurveyObservation& o : kept)
    if (o.set >= 0) o.set = static_cast<int>(std::distance(sets.begin(), sets.find(o.set)));
  network.sets = static_cast<int>(sets.size());
  std::vector<ObservationCovariance> blocks;
  for (const ObservationCovariance& block : network.covariances) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < block.covariance.rows(); ++i)
      if (index[static_cast<std::size_t>(block.first + i)] >= 0) rows.push_back(i);
    if (!rows.empty())
      blocks.push_back(
          {index[static_cast<std::size_t>(block.first + rows.front())], block.covariance(rows, rows)});
  }
  network.covariances = std::move(blocks);
  network.observations = std::move(kept);
}

Result<NetworkFile> read_gama(const std::string& path) {
  const Result<std::string> text = read_file(path, kLargestYaml);
  if (!text) return fail(text.error());
  if (const auto utf8 = check_utf8(*text, path); !utf8) return fail(utf8.error());
  XmlLog log(path, *text);
  pugi::xml_document document;
  log.parse(document);
  if (log.error) return fail(*log.error);
  const pugi::xml_node network = document.child("gama-local").child("network");
  const pugi::xml_node content = network.child("points-observations");
  if (!content) {
    log.fail(document.document_element(), "no <gama-local> with <network> and <points-observations>",
             "a gama-local document (.gkf)");
    return fail(*log.error);
  }
  NetworkFile file;
  file.description = std::string(without_blanks(network.child("description").text().get()));
  read_axes(network, file, log);
  read_parameters(network.child("parameters"), file, log);
  read_content(content, file, log);
  if (log.error) return fail(*log.error);
  leave_out_unused(file);
  return file;
}

}  // namespace octant::io
