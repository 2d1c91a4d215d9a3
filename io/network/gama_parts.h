// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: parts of the readers of survey networks.

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/network/network_file.h"
#include "io/network/xml_values.h"

namespace octant::io {

/// Angle of a gama-local document: gon, or degrees with minutes and seconds ("38-48-50.7").
struct GamaAngle {
  double value_rad = 0.0;
  double sigma_unit_rad = 0.0;  ///< unit of its standard deviation: 1e-4 gon, or a second of arc
};
[[nodiscard]] std::optional<GamaAngle> parse_gama_angle(const std::string& text);

/// Network of an XML document; `path` is the name in messages.
[[nodiscard]] Result<NetworkFile> parse_gama(const std::string& bytes, const std::string& path);
/// Network of the text of a survey.yaml.
[[nodiscard]] Result<NetworkFile> parse_survey(const std::string& text, const std::string& path);

/// Standard deviations of observations that state none, as <points-observations> gives them.
struct GamaSigmas {
  std::map<std::string, double> angular;  ///< by element, in its unit
  std::array<double, 3> distance{};       ///< a + b D^c [mm], D in km; 0: not given
};

/// Reads <point>, and <obs>, <height-differences>, <vectors> and <coordinates>, each a cluster that may have
/// a covariance matrix.
class GamaObservations {
 public:
  GamaObservations(NetworkFile& file, XmlLog& log) : file_(file), log_(log) {}
  /// Attributes of <points-observations>.
  void read_sigmas(const pugi::xml_node& node);
  void read_point(const pugi::xml_node& node);
  void read_cluster(const pugi::xml_node& cluster);

 private:
  int point(const pugi::xml_node& node, const std::string& id);
  void read_observation(const pugi::xml_node& node, const pugi::xml_node& cluster);
  void read_height_difference(const pugi::xml_node& node);
  void read_vector(const pugi::xml_node& node);
  void read_coordinates(const pugi::xml_node& node);
  void add_angle(const pugi::xml_node& node, SurveyObservation o);
  void add_distance(const pugi::xml_node& node, SurveyObservation o);
  /// @param sigma  in `unit`; nullopt where only a covariance matrix can give it
  void add(const pugi::xml_node& node, SurveyObservation o, double unit, std::optional<double> sigma);
  void check_sigmas(const pugi::xml_node& cluster);
  void read_covariance(const pugi::xml_node& node);
  [[nodiscard]] int end_point(const pugi::xml_node& node, const char* attribute);

  NetworkFile& file_;
  XmlLog& log_;
  GamaSigmas sigmas_;
  std::map<std::string, int> index_;
  // The current cluster.
  int first_ = 0;
  int set_ = -1;
  std::vector<double> units_;
};

}  // namespace octant::io
