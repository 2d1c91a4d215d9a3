// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/network/network_file.h"
#include "io/text/text.h"
#include "io/yaml/yaml_writer.h"

namespace octant::io {
namespace {

constexpr double kRadPerGon = std::numbers::pi / 200.0;

std::string in_gon(double angle_rad) { return exact(angle_rad / kRadPerGon); }

bool is_position(SurveyKind kind) { return kind >= SurveyKind::kX && kind <= SurveyKind::kDz; }

/// Sections of the observations, in the order of the reader.
class SurveyWriter {
 public:
  explicit SurveyWriter(const NetworkFile& file);
  [[nodiscard]] std::string text() const;

 private:
  [[nodiscard]] std::string points() const;
  void write_distance(std::size_t i);
  void write_sight(std::size_t i);
  /// Writes the components of one position or vector; returns the index after them.
  std::size_t write_position(std::size_t first);
  void write_other(std::size_t i);
  void write_correlations();

  [[nodiscard]] std::string id(int point) const {
    return yaml_text(file_.network.points[static_cast<std::size_t>(point)].id);
  }
  /// "id: o7, " of a member of a covariance block.
  [[nodiscard]] std::string observation_id(std::size_t i) const {
    return block_[i] < 0 ? "" : fmt::format("id: o{}, ", i + 1);
  }
  [[nodiscard]] const SurveyObservation& at(std::size_t i) const { return file_.network.observations[i]; }

  const NetworkFile& file_;
  std::vector<int> block_;                     ///< covariance block of each observation; -1: none
  std::vector<std::vector<std::size_t>> ids_;  ///< entries of each block
  int station_ = -1;                           ///< observation that began the current station
  std::string stations_, angles_, azimuths_, distances_, heights_, coordinates_, vectors_, correlations_;
};

SurveyWriter::SurveyWriter(const NetworkFile& file)
    : file_(file), block_(file.network.observations.size(), -1) {
  const std::vector<ObservationCovariance>& blocks = file.network.covariances;
  ids_.resize(blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (Eigen::Index i = 0; i < blocks[b].covariance.rows(); ++i)
      block_[static_cast<std::size_t>(blocks[b].first + i)] = static_cast<int>(b);
  for (std::size_t i = 0, next = 0; i < block_.size(); i = next) {
    next = i + 1;
    const SurveyKind kind = at(i).kind;
    const bool in_station = kind == SurveyKind::kDirection || kind == SurveyKind::kZenithAngle ||
                            at(i).instrument_height_m != 0.0 || at(i).target_height_m != 0.0;
    const bool is_distance = kind == SurveyKind::kHorizontalDistance || kind == SurveyKind::kSlopeDistance;
    if (is_position(kind))
      next = write_position(i);
    else if (is_distance && !in_station)
      write_distance(i);
    else if (is_distance || in_station)
      write_sight(i);
    else
      write_other(i);
    if (block_[i] >= 0) ids_[static_cast<std::size_t>(block_[i])].push_back(i);
  }
  write_correlations();
}

/// A sight at the current station, or at a new one if another point or set of directions begins.
void SurveyWriter::write_sight(std::size_t i) {
  const SurveyObservation& o = at(i);
  const bool continues = station_ >= 0 && at(static_cast<std::size_t>(station_)).from == o.from &&
                         (o.set < 0 || at(static_cast<std::size_t>(station_)).set == o.set);
  if (!continues) {
    station_ = static_cast<int>(i);
    stations_ += fmt::format("  - at: {}\n    sights:\n", id(o.from));
  }
  stations_ += fmt::format("      - {{{}to: {}", observation_id(i), id(o.to));
  if (o.instrument_height_m != 0.0)
    stations_ += fmt::format(", instrument_height_m: {}", o.instrument_height_m);
  if (o.target_height_m != 0.0) stations_ += fmt::format(", target_height_m: {}", o.target_height_m);
  if (o.kind == SurveyKind::kDirection || o.kind == SurveyKind::kZenithAngle) {
    const bool direction = o.kind == SurveyKind::kDirection;
    const char* name = direction ? "direction" : "zenith";
    stations_ += fmt::format(", {}_gon: {}, {}_sigma_gon: {}}}\n", name,
                             in_gon(direction ? file_.angle_sign * o.value : o.value), name, in_gon(o.sigma));
  } else {
    stations_ += fmt::format(", {}: {}, sigma_m: {}}}\n",
                             o.kind == SurveyKind::kSlopeDistance ? "slope_m" : "horizontal_m",
                             exact(o.value), exact(o.sigma));
  }
}

void SurveyWriter::write_distance(std::size_t i) {
  const SurveyObservation& o = at(i);
  distances_ += fmt::format(
      "  - {{{}from: {}, to: {}, {}: {}, sigma_m: {}}}\n", observation_id(i), id(o.from), id(o.to),
      o.kind == SurveyKind::kSlopeDistance ? "slope_m" : "horizontal_m", exact(o.value), exact(o.sigma));
}

void SurveyWriter::write_other(std::size_t i) {
  const SurveyObservation& o = at(i);
  if (o.kind == SurveyKind::kAngle)
    angles_ +=
        fmt::format("  - {{{}at: {}, from: {}, to: {}, angle_gon: {}, sigma_gon: {}}}\n", observation_id(i),
                    id(o.from), id(o.to), id(o.second), in_gon(file_.angle_sign * o.value), in_gon(o.sigma));
  if (o.kind == SurveyKind::kAzimuth)
    azimuths_ += fmt::format("  - {{{}from: {}, to: {}, azimuth_gon: {}, sigma_gon: {}}}\n",
                             observation_id(i), id(o.from), id(o.to),
                             in_gon(file_.angle_sign * (o.value - file_.north_rad)), in_gon(o.sigma));
  if (o.kind == SurveyKind::kHeightDifference)
    heights_ += fmt::format("  - {{{}from: {}, to: {}, difference_m: {}, sigma_m: {}}}\n", observation_id(i),
                            id(o.from), id(o.to), exact(o.value), exact(o.sigma));
}

std::size_t SurveyWriter::write_position(std::size_t first) {
  const bool is_vector = at(first).kind >= SurveyKind::kDx;
  const SurveyKind x = is_vector ? SurveyKind::kDx : SurveyKind::kX;
  std::vector<std::string> values(3, "null"), sigmas(3, "1");
  std::size_t end = first;
  for (; end < block_.size(); ++end) {
    const SurveyObservation& o = at(end);
    if (o.from != at(first).from || o.to != at(first).to || block_[end] != block_[first]) break;
    if (!is_position(o.kind) || (o.kind >= SurveyKind::kDx) != is_vector) break;
    if (end > first && o.kind <= at(end - 1).kind) break;
    const auto axis = static_cast<std::size_t>(static_cast<int>(o.kind) - static_cast<int>(x));
    values[axis] = exact(o.value);
    sigmas[axis] = exact(o.sigma);
  }
  std::string& section = is_vector ? vectors_ : coordinates_;
  section += fmt::format("  - {{{}", observation_id(first));
  section += is_vector ? fmt::format("from: {}, to: {}, vector_m", id(at(first).from), id(at(first).to))
                       : fmt::format("point: {}, position_m", id(at(first).from));
  section += fmt::format(": [{}], sigma_m: [{}]}}\n", fmt::join(values, ", "), fmt::join(sigmas, ", "));
  return end;
}

void SurveyWriter::write_correlations() {
  for (std::size_t b = 0; b < ids_.size(); ++b) {
    const Eigen::MatrixXd& c = file_.network.covariances[b].covariance;
    if (c.rows() < 2) continue;
    std::vector<std::string> ids, values;
    for (const std::size_t i : ids_[b]) ids.push_back(fmt::format("o{}", i + 1));
    for (Eigen::Index i = 0; i < c.rows(); ++i)
      for (Eigen::Index k = i + 1; k < c.rows(); ++k)
        values.push_back(c(i, k) == 0.0 ? "0" : exact(c(i, k) / std::sqrt(c(i, i)) / std::sqrt(c(k, k))));
    correlations_ += fmt::format("  - observations: [{}]\n    correlation: [{}]\n", fmt::join(ids, ", "),
                                 fmt::join(values, ", "));
  }
}

std::string SurveyWriter::points() const {
  std::string text;
  for (const NetworkPoint& p : file_.network.points) {
    std::vector<std::string> position;
    for (std::size_t i = 0; i < 3; ++i)
      position.push_back(p.known[i] ? exact(p.p_map_m[static_cast<int>(i)]) : "null");
    text += fmt::format("  - {{id: {}, position_m: [{}]", yaml_text(p.id), fmt::join(position, ", "));
    for (const auto& [key, role] : {std::pair{"fixed", CoordinateRole::kFixed},
                                    {"datum", CoordinateRole::kDatum},
                                    {"adjusted", CoordinateRole::kFree}}) {
      std::string axes;
      for (std::size_t i = 0; i < 3; ++i)
        if (p.role[i] == role) axes += "xyz"[i];
      // An empty list of adjusted coordinates is different from none.
      if (!axes.empty() || role == CoordinateRole::kFree)
        text += fmt::format(", {}: {}", key, yaml_text(axes));
    }
    text += "}\n";
  }
  return text;
}

std::string SurveyWriter::text() const {
  std::string text = "octant_survey: 1\n";
  if (!file_.description.empty()) text += fmt::format("name: {}\n", yaml_text(file_.description));
  text += fmt::format("axes: {}\nangles: {}\nsigmas: {}\n", file_.axes,
                      file_.clockwise ? "clockwise" : "counter_clockwise",
                      file_.sigmas_a_posteriori ? "scaled" : "stated");
  if (std::isfinite(file_.outlier_limit_m))
    text += fmt::format("outlier_limit_m: {}\n", file_.outlier_limit_m);
  if (file_.datum_follows) text += "datum_follows: true\n";
  text += "points:\n" + points();
  for (const auto& [key, section] : {std::pair<const char*, const std::string&>{"stations", stations_},
                                     {"horizontal_angles", angles_},
                                     {"azimuths", azimuths_},
                                     {"distances", distances_},
                                     {"height_differences", heights_},
                                     {"coordinates", coordinates_},
                                     {"vectors", vectors_},
                                     {"correlations", correlations_}})
    if (!section.empty()) text += fmt::format("{}:\n{}", key, section);
  return text;
}

}  // namespace

std::string survey_to_yaml(const NetworkFile& file) { return SurveyWriter(file).text(); }

}  // namespace octant::io
