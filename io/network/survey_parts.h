// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the reader of survey.yaml.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "io/network/network_file.h"
#include "io/yaml/yaml_reader.h"

namespace octant::io {

/// Sigmas of the observations of a station; nullopt: each observation states its own.
struct StationSigmas {
  std::optional<double> direction_rad, zenith_rad, distance_m;
  double distance_per_m = 0.0;
};

/// Correlated observations, in any place of the file.
struct CorrelatedObservations {
  std::vector<int> members;
  Eigen::MatrixXd covariance;
};

/// Reads the sections of a survey.yaml in turn. Errors are those of the log.
class SurveyYaml {
 public:
  SurveyYaml(NetworkFile& file, YamlLog& log) : file_(file), log_(log) {}
  void read_root(YamlMap& root);

 private:
  using Read = void (SurveyYaml::*)(YamlMap&);
  void each(YamlMap& root, const char* key, Read read);
  void read_entry(YamlMap& map, Read read);
  void leave_out_unobserved();
  void gather_correlated();
  void read_correlations(YamlMap& map);
  void correlate(YamlMap& map, const char* key, CorrelatedObservations block);
  void read_roles(YamlMap& map, NetworkPoint& p);
  void read_point(YamlMap& map);
  void read_station(YamlMap& map);
  void read_sight(YamlMap& sight);
  void read_horizontal_angle(YamlMap& map);
  void read_azimuth(YamlMap& map);
  void read_distance(YamlMap& map);
  void read_height_difference(YamlMap& map);
  void read_coordinates(YamlMap& map);
  void read_vector(YamlMap& map);
  void add_distance(YamlMap& map, SurveyObservation o);
  void add_position(YamlMap& map, const char* key, SurveyKind first, SurveyObservation o);
  void add_covariance(YamlMap& map, int first);
  void add(YamlMap& map, const char* sigma_key, SurveyObservation o, std::optional<double> sigma);

  /// Items of a list of three; empty if it is absent, or after an error.
  [[nodiscard]] std::vector<YamlNode> three_values(YamlMap& map, const char* key);
  [[nodiscard]] int point(YamlMap& map, const char* key);
  /// Angle of a key with the suffix _gon, _deg or _rad; nullopt if it is absent.
  [[nodiscard]] std::optional<double> angle_rad(YamlMap& map, const std::string& key);
  [[nodiscard]] std::optional<double> sigma_rad(YamlMap& map, const std::string& key);
  [[nodiscard]] StationSigmas sigmas_of(YamlMap& station);

  NetworkFile& file_;
  YamlLog& log_;
  std::map<std::string, int> index_;
  std::map<std::string, std::pair<int, int>> ids_;  ///< observations of an id: the first, and the one after
  std::vector<CorrelatedObservations> correlated_;
  std::vector<bool> is_correlated_;    ///< by observation
  std::vector<bool> adjusted_stated_;  ///< by point
  // The current station.
  SurveyObservation station_;
  StationSigmas sigmas_;
};

}  // namespace octant::io
