// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "io/network/gama_parts.h"

namespace octant::io {
namespace {

constexpr double kMillimetre = 1e-3;
constexpr double kGon = std::numbers::pi / 200.0;
constexpr double kDegree = std::numbers::pi / 180.0;

const std::map<std::string, SurveyKind, std::less<>> kObservationKinds = {
    {"direction", SurveyKind::kDirection},
    {"azimuth", SurveyKind::kAzimuth},
    {"angle", SurveyKind::kAngle},
    {"z-angle", SurveyKind::kZenithAngle},
    {"distance", SurveyKind::kHorizontalDistance},
    {"s-distance", SurveyKind::kSlopeDistance}};

}  // namespace

std::optional<GamaAngle> parse_gama_angle(const std::string& text) {
  double value = 0.0;
  if (parse_number(text, value) == NumberText::kNumber && std::isfinite(value))
    return GamaAngle{value * kGon, 1e-4 * kGon};
  std::string_view rest = text;
  const double sign = rest.starts_with('-') ? -1.0 : 1.0;
  if (rest.starts_with('-') || rest.starts_with('+')) rest.remove_prefix(1);
  double degrees = 0.0, unit = 1.0;
  for (int part = 0; part < 3; ++part, unit /= 60.0) {
    const std::size_t end = part < 2 ? rest.find('-') : rest.size();
    if (end == std::string_view::npos || parse_number(rest.substr(0, end), value) != NumberText::kNumber ||
        !(value >= 0.0 && (part == 0 || value < 60.0 + 1e-9)) || !std::isfinite(value))
      return std::nullopt;
    degrees += unit * value;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return GamaAngle{sign * degrees * kDegree, kDegree / 3600.0};
}

void GamaObservations::read_cluster(const pugi::xml_node& cluster) {
  first_ = static_cast<int>(file_.network.observations.size());
  set_ = -1;
  units_.clear();
  const std::string_view kind = cluster.name();
  pugi::xml_node covariance;
  for (const pugi::xml_node& node : cluster.children()) {
    const std::string_view name = node.name();
    if (node.type() != pugi::node_element) continue;
    if (name == "cov-mat")
      covariance = node;
    else if (kind == "obs" && kObservationKinds.contains(name))
      read_observation(node, cluster);
    else if (kind == "height-differences" && name == "dh")
      read_height_difference(node);
    else if (kind == "vectors" && name == "vec")
      read_vector(node);
    else if (kind == "coordinates" && name == "point")
      read_coordinates(node);
    else
      log_.fail(node, fmt::format("<{}> in <{}>", name, kind), "an observation of this kind of cluster");
  }
  if (covariance)
    read_covariance(covariance);
  else
    check_sigmas(cluster);
}

void GamaObservations::check_sigmas(const pugi::xml_node& cluster) {
  for (std::size_t i = static_cast<std::size_t>(first_); i < file_.network.observations.size(); ++i) {
    const SurveyObservation& o = file_.network.observations[i];
    if (o.sigma > 0.0 || log_.error) continue;
    if (o.sigma < 0.0)
      log_.fail(cluster, "an observation without standard deviation",
                "'stdev', a value of <points-observations>, or <cov-mat>");
    else
      log_.fail(cluster, "standard deviation 0", "a positive number");
    log_.error->line = o.line;
  }
}

void GamaObservations::add(const pugi::xml_node& node, SurveyObservation o, double unit,
                           std::optional<double> sigma) {
  o.line = log_.line(node);
  o.sigma = sigma ? *sigma * unit : -1.0;
  if (sigma && *sigma < 0.0)
    log_.fail(node, fmt::format("standard deviation {} of <{}>", exact(*sigma), node.name()),
              "a positive number");
  file_.network.observations.push_back(o);
  units_.push_back(unit);
}

void GamaObservations::read_observation(const pugi::xml_node& node, const pugi::xml_node& cluster) {
  SurveyObservation o;
  o.kind = kObservationKinds.find(std::string_view(node.name()))->second;
  o.from = end_point(node.attribute("from") ? node : cluster, "from");
  const bool angle = o.kind == SurveyKind::kAngle;
  o.to = end_point(node, angle && !node.attribute("to") ? "bs" : "to");  // old files: to, rs for bs, fs
  if (angle) o.second = end_point(node, node.attribute("rs") ? "rs" : "fs");
  o.instrument_height_m =
      log_.number(node, "from_dh").value_or(log_.number(cluster, "from_dh").value_or(0.0));
  o.target_height_m = log_.number(node, "to_dh").value_or(0.0);
  if (o.kind <= SurveyKind::kZenithAngle) return add_angle(node, o);
  add_distance(node, o);
}

void GamaObservations::add_angle(const pugi::xml_node& node, SurveyObservation o) {
  const auto angle = parse_gama_angle(XmlLog::text(node, "val"));
  if (!angle)
    return log_.fail(node, fmt::format("val={} of <{}>", in_quotes(XmlLog::text(node, "val")), node.name()),
                     "gon, or degrees-minutes-seconds such as 38-48-50.7");
  o.value = angle->value_rad;
  if (o.kind != SurveyKind::kZenithAngle) o.value *= file_.angle_sign;
  if (o.kind == SurveyKind::kAzimuth) o.value += file_.north_rad;
  // A zenith angle beyond the nadir was observed in the second face.
  if (o.kind == SurveyKind::kZenithAngle && o.value > std::numbers::pi)
    o.value = 2.0 * std::numbers::pi - o.value;
  if (o.kind == SurveyKind::kDirection) {
    if (set_ < 0) set_ = file_.network.sets++;
    o.set = set_;
  }
  std::optional<double> sigma = log_.number(node, "stdev");
  if (const auto at = sigmas_.angular.find(node.name()); !sigma && at != sigmas_.angular.end())
    sigma = at->second;
  add(node, o, angle->sigma_unit_rad, sigma);
}

void GamaObservations::add_distance(const pugi::xml_node& node, SurveyObservation o) {
  o.value = log_.required_number(node, "val");
  if (!(o.value > 0.0)) log_.fail(node, fmt::format("distance {}", exact(o.value)), "a positive number");
  std::optional<double> sigma = log_.number(node, "stdev");
  const auto& [a, b, c] = sigmas_.distance;
  if (!sigma && (a > 0.0 || b > 0.0)) sigma = a + b * std::pow(o.value / 1000.0, c);
  add(node, o, kMillimetre, sigma);
}

void GamaObservations::read_height_difference(const pugi::xml_node& node) {
  SurveyObservation o{.kind = SurveyKind::kHeightDifference,
                      .from = end_point(node, "from"),
                      .to = end_point(node, "to"),
                      .value = log_.required_number(node, "val")};
  std::optional<double> sigma = log_.number(node, "stdev");
  if (const auto length_km = log_.number(node, "dist", kNotNegative); !sigma && length_km)
    sigma = file_.sigma_unit * std::sqrt(*length_km);
  add(node, o, kMillimetre, sigma);
}

void GamaObservations::read_vector(const pugi::xml_node& node) {
  SurveyObservation o{.from = end_point(node, "from"), .to = end_point(node, "to")};
  const double heights_m =
      log_.number(node, "from_dh").value_or(0.0) - log_.number(node, "to_dh").value_or(0.0);
  for (const auto& [kind, name] :
       {std::pair{SurveyKind::kDx, "dx"}, {SurveyKind::kDy, "dy"}, {SurveyKind::kDz, "dz"}}) {
    o.kind = kind;
    o.value = log_.required_number(node, name) + (kind == SurveyKind::kDz ? heights_m : 0.0);
    add(node, o, kMillimetre, std::nullopt);
  }
}

void GamaObservations::read_coordinates(const pugi::xml_node& node) {
  read_point(node);
  SurveyObservation o{.from = end_point(node, "id")};
  for (const auto& [kind, name] :
       {std::pair{SurveyKind::kX, "x"}, {SurveyKind::kY, "y"}, {SurveyKind::kZ, "z"}}) {
    o.kind = kind;
    if (!node.attribute(name)) continue;
    o.value = log_.required_number(node, name);
    add(node, o, kMillimetre, std::nullopt);
  }
}

void GamaObservations::read_covariance(const pugi::xml_node& node) {
  const auto n = static_cast<Eigen::Index>(units_.size());
  const auto dim = static_cast<Eigen::Index>(log_.required_number(node, "dim"));
  const auto band = static_cast<Eigen::Index>(log_.required_number(node, "band"));
  const std::vector<double> values = log_.numbers(node, node.text().get());
  if (log_.error) return;
  if (dim != n || band < 0 || band >= std::max<Eigen::Index>(n, 1))
    return log_.fail(node, fmt::format("<cov-mat> with dim {} and band {}", dim, band),
                     fmt::format("dim {} (number of observations), and a smaller band", n));
  const Eigen::Index expected = n * (band + 1) - band * (band + 1) / 2;
  if (static_cast<Eigen::Index>(values.size()) != expected)
    return log_.fail(node, fmt::format("<cov-mat> with {} numbers", values.size()),
                     fmt::format("{} numbers: the upper triangle, by rows", expected));
  // Rows without covariances to later ones end a block: a long list of vectors has small blocks.
  const auto value = [&](Eigen::Index i, Eigen::Index k) {
    const Eigen::Index shorter = std::max<Eigen::Index>(i - n + band, 0);
    return values[static_cast<std::size_t>(i * (band + 1) - shorter * (shorter + 1) / 2 + k - i)];
  };
  const auto unit = [&](Eigen::Index i) { return units_[static_cast<std::size_t>(i)]; };
  for (Eigen::Index begin = 0, end = 0; begin < n; begin = end) {
    for (Eigen::Index i = begin, reach = begin; i <= reach; end = ++i)
      for (Eigen::Index k = i; k <= std::min(i + band, n - 1); ++k)
        if (value(i, k) != 0.0) reach = std::max(reach, k);
    ObservationCovariance block{first_ + static_cast<int>(begin),
                                Eigen::MatrixXd::Zero(end - begin, end - begin)};
    for (Eigen::Index i = begin; i < end; ++i) {
      for (Eigen::Index k = i; k <= std::min(i + band, end - 1); ++k)
        block.covariance(i - begin, k - begin) = block.covariance(k - begin, i - begin) =
            value(i, k) * unit(i) * unit(k);
      file_.network.observations[static_cast<std::size_t>(first_ + i)].sigma =
          std::sqrt(std::max(block.covariance(i - begin, i - begin), 0.0));
    }
    if (end - begin > 1 || block.covariance(0, 0) <= 0.0)
      file_.network.covariances.push_back(std::move(block));
  }
}

}  // namespace octant::io
