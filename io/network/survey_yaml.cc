// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "io/network/gama_parts.h"
#include "io/network/survey_parts.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"

namespace octant::io {

void SurveyYaml::read_root(YamlMap& root) {
  file_.description = root.text("name", "");
  file_.sigma_unit = 1.0;
  file_.sigmas_a_posteriori = root.choice<bool>("sigmas", {{"stated", false}, {"scaled", true}}, false);
  file_.outlier_limit_m = root.number("outlier_limit_m", std::numeric_limits<double>::infinity(), kPositive);
  file_.datum_follows = root.boolean("datum_follows", false);
  std::vector<std::pair<std::string, std::string>> axes;
  for (const char* name : kSurveyAxes) axes.emplace_back(name, name);
  set_axes(file_, root.choice<std::string>("axes", axes, "en"),
           root.choice<bool>("angles", {{"clockwise", true}, {"counter_clockwise", false}}, true));
  each(root, "points", &SurveyYaml::read_point);
  each(root, "stations", &SurveyYaml::read_station);
  each(root, "horizontal_angles", &SurveyYaml::read_horizontal_angle);
  each(root, "azimuths", &SurveyYaml::read_azimuth);
  each(root, "distances", &SurveyYaml::read_distance);
  each(root, "height_differences", &SurveyYaml::read_height_difference);
  each(root, "coordinates", &SurveyYaml::read_coordinates);
  each(root, "vectors", &SurveyYaml::read_vector);
  each(root, "correlations", &SurveyYaml::read_correlations);
  if (log_.error) return;
  gather_correlated();
  leave_out_unobserved();
}

/// Coordinates are adjusted by default if observations depend on them: not the heights of a plane network.
void SurveyYaml::leave_out_unobserved() {
  std::vector<std::array<bool, 3>> observed(file_.network.points.size(), std::array{false, false, false});
  for (const SurveyObservation& o : file_.network.observations) {
    const bool height =
        o.kind == SurveyKind::kHeightDifference || o.kind == SurveyKind::kZ || o.kind == SurveyKind::kDz;
    const bool space = o.kind == SurveyKind::kZenithAngle || o.kind == SurveyKind::kSlopeDistance;
    for (const int p : {o.from, o.to, o.second}) {
      if (p < 0) continue;
      std::array<bool, 3>& axes = observed[static_cast<std::size_t>(p)];
      axes[0] = axes[1] = axes[0] || !height;
      axes[2] = axes[2] || height || space;
    }
  }
  for (std::size_t p = 0; p < observed.size(); ++p)
    for (std::size_t i = 0; i < 3; ++i)
      if (CoordinateRole& role = file_.network.points[p].role[i];
          !adjusted_stated_[p] && !observed[p][i] && role == CoordinateRole::kFree)
        role = CoordinateRole::kAbsent;
}

void SurveyYaml::each(YamlMap& root, const char* key, Read read) {
  const std::vector<YamlNode> nodes = root.list(key);
  for (std::size_t i = 0; i < nodes.size() && !log_.error; ++i) {
    YamlMap map(nodes[i], fmt::format("{}[{}]", key, i), log_);
    read_entry(map, read);
  }
}

/// Reads a mapping; an id names its observations.
void SurveyYaml::read_entry(YamlMap& map, Read read) {
  const int first = static_cast<int>(file_.network.observations.size());
  (this->*read)(map);
  const int last = static_cast<int>(file_.network.observations.size());
  if (first < last && map.has("id"))
    if (const std::string id = map.required_text("id"); !ids_.emplace(id, std::pair(first, last)).second)
      map.fail("id", "a second observation " + in_quotes(id), "another id");
  map.finish();
}

/// Moves the members of each covariance block to its first member, because they must follow one another.
void SurveyYaml::gather_correlated() {
  std::vector<SurveyObservation>& observations = file_.network.observations;
  std::map<int, CorrelatedObservations*> begins;
  for (CorrelatedObservations& block : correlated_) begins[std::ranges::min(block.members)] = &block;
  is_correlated_.resize(observations.size(), false);
  std::vector<SurveyObservation> ordered;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!is_correlated_[i]) ordered.push_back(observations[i]);
    const auto at = begins.find(static_cast<int>(i));
    if (at == begins.end()) continue;
    file_.network.covariances.push_back(
        {static_cast<int>(ordered.size()), std::move(at->second->covariance)});
    for (const int k : at->second->members) ordered.push_back(observations[static_cast<std::size_t>(k)]);
  }
  observations = std::move(ordered);
}

/// Adds a covariance block of observations that are in no other block.
void SurveyYaml::correlate(YamlMap& map, const char* key, CorrelatedObservations block) {
  is_correlated_.resize(file_.network.observations.size(), false);
  for (const int i : block.members) {
    if (is_correlated_[static_cast<std::size_t>(i)])
      return map.fail(key, "an observation that has a covariance already", "each observation once");
    is_correlated_[static_cast<std::size_t>(i)] = true;
  }
  if (block.covariance.llt().info() != Eigen::Success)
    return map.fail(key, "a matrix that is not positive definite", "the upper triangle, by rows");
  correlated_.push_back(std::move(block));
}

void SurveyYaml::read_correlations(YamlMap& map) {
  CorrelatedObservations block;
  for (const YamlNode& node : map.list("observations")) {
    const std::string id = text_of(node, map.path("observations"), log_);
    const auto at = ids_.find(id);
    if (at == ids_.end()) return map.fail("observations", in_quotes(id), "ids of observations");
    for (int i = at->second.first; i < at->second.second; ++i) block.members.push_back(i);
  }
  const std::size_t n = block.members.size();
  if (n < 2) return map.fail_missing("observations", "ids of at least two observations");
  const std::vector<double> upper = map.numbers("correlation", n * (n - 1) / 2);
  if (log_.error) return;
  if (upper.empty()) return map.fail_missing("correlation", "the upper triangle, by rows");
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::VectorXd sigmas(size);
  for (Eigen::Index i = 0; i < size; ++i)
    sigmas[i] =
        file_.network.observations[static_cast<std::size_t>(block.members[static_cast<std::size_t>(i)])]
            .sigma;
  block.covariance = Eigen::MatrixXd::Identity(size, size);
  auto value = upper.begin();
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index k = i + 1; k < size; ++k) block.covariance(i, k) = block.covariance(k, i) = *value++;
  block.covariance = sigmas.asDiagonal() * block.covariance * sigmas.asDiagonal();
  correlate(map, "correlation", std::move(block));
}

void SurveyYaml::read_point(YamlMap& map) {
  NetworkPoint p{.id = map.required_text("id"), .known = {false, false, false}};
  if (!index_.emplace(p.id, static_cast<int>(file_.network.points.size())).second)
    map.fail("id", "a second point " + in_quotes(p.id), "one of them");
  const std::vector<YamlNode> position = three_values(map, "position_m");
  for (std::size_t i = 0; i < 3 && position.size() == 3; ++i) {
    if (position[i].is_null()) continue;
    p.p_map_m[static_cast<int>(i)] = number_of(position[i], map.path("position_m"), log_);
    p.known[i] = true;
  }
  read_roles(map, p);
  file_.network.points.push_back(std::move(p));
}

std::vector<YamlNode> SurveyYaml::three_values(YamlMap& map, const char* key) {
  const YamlNode list = map.block(key);
  return list.is_defined() ? list_of(list, map.path(key), log_, 3) : std::vector<YamlNode>{};
}

/// Letters of the coordinates that are fixed, define a free datum, or are adjusted. Without the last,
/// all others are adjusted that are observed.
void SurveyYaml::read_roles(YamlMap& map, NetworkPoint& p) {
  adjusted_stated_.push_back(map.has("adjusted"));
  p.role.fill(adjusted_stated_.back() ? CoordinateRole::kAbsent : CoordinateRole::kFree);
  for (const auto& [key, role] : {std::pair{"adjusted", CoordinateRole::kFree},
                                  {"datum", CoordinateRole::kDatum},
                                  {"fixed", CoordinateRole::kFixed}})
    for (const char c : map.text(key, "")) {
      if (c < 'x' || c > 'z') return map.fail(key, fmt::format("'{}'", c), "letters out of x, y, z");
      const auto axis = static_cast<std::size_t>(c - 'x');
      p.role[axis] = role;
      if (role == CoordinateRole::kFixed && !p.known[axis])
        return map.fail(key, fmt::format("'{}'", c), "coordinates that position_m states");
    }
}

int SurveyYaml::point(YamlMap& map, const char* key) {
  const std::string id = map.required_text(key);
  const auto at = index_.find(id);
  if (at != index_.end()) return at->second;
  map.fail(key, in_quotes(id), "the id of one of the points");
  return 0;
}

Result<NetworkFile> parse_survey(const std::string& text, const std::string& path) {
  return yaml_content<NetworkFile>(
      parse_yaml(text, path), path, "octant_survey",
      [](YamlMap& root, YamlLog& log, NetworkFile& file) { SurveyYaml(file, log).read_root(root); });
}

Result<NetworkFile> read_survey(const std::string& path) {
  const Result<std::string> text = read_file(path, kLargestYaml);
  if (!text) return fail(text.error());
  return parse_survey(*text, path);
}

}  // namespace octant::io
