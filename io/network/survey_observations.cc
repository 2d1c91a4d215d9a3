// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "io/network/survey_parts.h"

namespace octant::io {

std::optional<double> SurveyYaml::angle_rad(YamlMap& map, const std::string& key) {
  for (const auto& [unit, factor] :
       {std::pair{"_gon", std::numbers::pi / 200.0}, {"_deg", std::numbers::pi / 180.0}, {"_rad", 1.0}})
    if (const auto value = map.optional_number(key + unit)) return *value * factor;
  return std::nullopt;
}

std::optional<double> SurveyYaml::sigma_rad(YamlMap& map, const std::string& key) {
  const std::optional<double> sigma = angle_rad(map, key);
  if (sigma && !(*sigma > 0.0)) map.fail(key + "_gon", "a sigma that is not positive", "a positive number");
  return sigma;
}

StationSigmas SurveyYaml::sigmas_of(YamlMap& station) {
  StationSigmas sigmas;
  YamlMap map(station.block("sigmas"), station.path("sigmas"), log_);
  sigmas.direction_rad = sigma_rad(map, "direction");
  sigmas.zenith_rad = sigma_rad(map, "zenith");
  sigmas.distance_m = map.optional_number("distance_m", kPositive);
  sigmas.distance_per_m = map.number("distance_m_per_m", 0.0, kNotNegative);
  map.finish();
  return sigmas;
}

void SurveyYaml::add(YamlMap& map, const char* sigma_key, SurveyObservation o, std::optional<double> sigma) {
  o.line = map.node().line();
  o.sigma = sigma.value_or(1.0);
  if (!sigma) map.fail_missing(sigma_key, "the standard deviation of the observation");
  file_.network.observations.push_back(o);
}

void SurveyYaml::read_station(YamlMap& map) {
  station_ = {.from = point(map, "at"), .instrument_height_m = map.number("instrument_height_m", 0.0)};
  sigmas_ = sigmas_of(map);
  const std::vector<YamlNode> sights = map.list("sights");
  for (std::size_t i = 0; i < sights.size() && !log_.error; ++i) {
    YamlMap sight(sights[i], fmt::format("{}[{}]", map.path("sights"), i), log_);
    read_entry(sight, &SurveyYaml::read_sight);
  }
  sigmas_ = {};
}

void SurveyYaml::read_sight(YamlMap& sight) {
  SurveyObservation o = station_;
  o.to = point(sight, "to");
  o.instrument_height_m = sight.number("instrument_height_m", o.instrument_height_m);
  o.target_height_m = sight.number("target_height_m", 0.0);
  const std::optional<double> direction_sigma = sigma_rad(sight, "direction_sigma"),
                              zenith_sigma = sigma_rad(sight, "zenith_sigma");
  if (const auto direction = angle_rad(sight, "direction")) {
    o.kind = SurveyKind::kDirection;
    o.value = file_.angle_sign * *direction;
    if (station_.set < 0) station_.set = file_.network.sets++;
    o.set = station_.set;
    add(sight, "direction_sigma_gon", o, direction_sigma ? direction_sigma : sigmas_.direction_rad);
  }
  o.set = -1;
  if (auto zenith = angle_rad(sight, "zenith")) {
    o.kind = SurveyKind::kZenithAngle;
    // A zenith angle beyond the nadir was observed in the second face.
    o.value = *zenith > std::numbers::pi ? 2.0 * std::numbers::pi - *zenith : *zenith;
    add(sight, "zenith_sigma_gon", o, zenith_sigma ? zenith_sigma : sigmas_.zenith_rad);
  }
  add_distance(sight, o);
}

/// Distances of the keys slope_m and horizontal_m.
void SurveyYaml::add_distance(YamlMap& map, SurveyObservation o) {
  const std::optional<double> stated_m = map.optional_number("sigma_m", kPositive);
  for (const auto& [key, kind] : {std::pair{"slope_m", SurveyKind::kSlopeDistance},
                                  {"horizontal_m", SurveyKind::kHorizontalDistance}}) {
    const std::optional<double> length_m = map.optional_number(key, kPositive);
    if (!length_m) continue;
    o.kind = kind;
    o.value = *length_m;
    std::optional<double> sigma_m = stated_m;
    if (!sigma_m && sigmas_.distance_m) sigma_m = *sigmas_.distance_m + sigmas_.distance_per_m * o.value;
    add(map, "sigma_m", o, sigma_m);
  }
}

void SurveyYaml::read_distance(YamlMap& map) {
  SurveyObservation o{.from = point(map, "from"), .to = point(map, "to")};
  const std::size_t before = file_.network.observations.size();
  add_distance(map, o);
  if (file_.network.observations.size() == before)
    map.fail_missing("slope_m", "a distance: slope_m or horizontal_m");
}

void SurveyYaml::read_horizontal_angle(YamlMap& map) {
  SurveyObservation o{.kind = SurveyKind::kAngle,
                      .from = point(map, "at"),
                      .to = point(map, "from"),
                      .second = point(map, "to")};
  const auto angle = angle_rad(map, "angle");
  if (!angle) return map.fail_missing("angle_gon", "an angle");
  o.value = file_.angle_sign * *angle;
  add(map, "sigma_gon", o, sigma_rad(map, "sigma"));
}

void SurveyYaml::read_azimuth(YamlMap& map) {
  SurveyObservation o{.kind = SurveyKind::kAzimuth, .from = point(map, "from"), .to = point(map, "to")};
  const auto azimuth = angle_rad(map, "azimuth");
  if (!azimuth) return map.fail_missing("azimuth_gon", "an angle");
  o.value = file_.angle_sign * *azimuth + file_.north_rad;
  add(map, "sigma_gon", o, sigma_rad(map, "sigma"));
}

void SurveyYaml::read_height_difference(YamlMap& map) {
  SurveyObservation o{
      .kind = SurveyKind::kHeightDifference, .from = point(map, "from"), .to = point(map, "to")};
  o.value = map.required_number("difference_m");
  std::optional<double> sigma_m = map.optional_number("sigma_m", kPositive);
  const auto length_km = map.optional_number("length_km", kPositive);
  const auto per_root = map.optional_number("sigma_m_per_sqrt_km", kPositive);
  if (!sigma_m && length_km && per_root) sigma_m = *per_root * std::sqrt(*length_km);
  add(map, "sigma_m", o, sigma_m);
}

void SurveyYaml::read_coordinates(YamlMap& map) {
  const SurveyObservation o{.from = point(map, "point")};
  const std::size_t before = file_.network.observations.size();
  add_position(map, "position_m", SurveyKind::kX, o);
  NetworkPoint& p = file_.network.points[static_cast<std::size_t>(o.from)];
  for (std::size_t i = before; i < file_.network.observations.size(); ++i) {
    const SurveyObservation& observed = file_.network.observations[i];
    const auto axis =
        static_cast<std::size_t>(static_cast<int>(observed.kind) - static_cast<int>(SurveyKind::kX));
    if (p.known[axis]) continue;
    p.p_map_m[static_cast<int>(axis)] = observed.value;
    p.known[axis] = true;
  }
}

void SurveyYaml::read_vector(YamlMap& map) {
  add_position(map, "vector_m", SurveyKind::kDx, {.from = point(map, "from"), .to = point(map, "to")});
}

/// Three numbers (null: not observed) with `sigma_m` or the upper triangle of their covariance.
void SurveyYaml::add_position(YamlMap& map, const char* key, SurveyKind first_kind, SurveyObservation o) {
  const std::vector<YamlNode> values = three_values(map, key);
  if (values.size() != 3) return map.fail_missing(key, "[x, y, z], null where not observed");
  const int first = static_cast<int>(file_.network.observations.size());
  const bool has_covariance = map.has("covariance_m2");
  std::vector<double> sigmas_m;
  if (has_covariance && map.has("sigma_m"))
    return map.fail("covariance_m2", "a covariance and a sigma", "one of them");
  if (!has_covariance && map.has("sigma_m"))
    sigmas_m = map.get("sigma_m").is_sequence()
                   ? map.numbers("sigma_m", 3, kPositive)
                   : std::vector<double>(3, map.required_number("sigma_m", kPositive));
  for (std::size_t i = 0; i < 3 && !log_.error; ++i) {
    if (values[i].is_null()) continue;
    o.kind = static_cast<SurveyKind>(static_cast<int>(first_kind) + static_cast<int>(i));
    o.value = number_of(values[i], map.path(key), log_);
    std::optional<double> sigma_m;
    if (has_covariance) sigma_m = 1.0;
    if (sigmas_m.size() == 3) sigma_m = sigmas_m[i];
    add(map, "sigma_m", o, sigma_m);
  }
  if (has_covariance && !log_.error) add_covariance(map, first);
}

void SurveyYaml::add_covariance(YamlMap& map, int first) {
  const auto n = static_cast<Eigen::Index>(file_.network.observations.size()) - first;
  const std::vector<double> upper = map.numbers("covariance_m2", static_cast<std::size_t>(n * (n + 1) / 2));
  if (log_.error) return;
  CorrelatedObservations block{{}, Eigen::MatrixXd(n, n)};
  auto value = upper.begin();
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = i; k < n; ++k) block.covariance(i, k) = block.covariance(k, i) = *value++;
  for (Eigen::Index i = 0; i < n; ++i) {
    block.members.push_back(first + static_cast<int>(i));
    file_.network.observations[static_cast<std::size_t>(first + i)].sigma =
        std::sqrt(std::max(block.covariance(i, i), 0.0));
  }
  correlate(map, "covariance_m2", std::move(block));
}

}  // namespace octant::io
