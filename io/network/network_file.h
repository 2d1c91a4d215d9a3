// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "models/network/network.h"
#include "models/support/result.h"

namespace octant::io {

/// Survey network as its file describes it. Coordinates are those of the file. Angles of the file are
/// `angle_sign` times those of the network, and azimuths count from north (both by set_axes).
struct NetworkFile {
  std::string description;
  Network network;
  double sigma_unit = 10.0;  ///< a priori sigma of unit weight
  bool sigmas_a_posteriori = true;
  double outlier_limit_m = 1.0;  ///< largest misclosure at the approximate coordinates that is used
  bool datum_follows = false;    ///< datum points are updated with each step of the adjustment
  std::string axes = "en";       ///< directions of +x and +y: "en" is east and north
  bool clockwise = true;         ///< sense of angles in the file
  double angle_sign = 1.0;
  double north_rad = 0.0;  ///< angle of north from +x towards +y
  std::vector<std::string> warnings;
};

/// The eight orientations of the axes, the right-handed ones first.
inline constexpr std::array kSurveyAxes = {"en", "nw", "se", "ws", "ne", "sw", "es", "wn"};
/// Sets the axes, the sense of angles and what follows from them.
void set_axes(NetworkFile& file, const std::string& axes, bool clockwise);

/// Reads a network in one of the two formats below, XML if it begins with '<'.
[[nodiscard]] Result<NetworkFile> read_network(const std::string& path);
/// Is the file an XML document of gama-local?
[[nodiscard]] bool is_gama(const std::string& path);

/// Reads a network in the XML format of GNU Gama (gama-local, .gkf): points, observations with standard
/// deviations or covariance matrices, all eight orientations of the axes, gon and degrees. Errors: kBadInput
/// with the line. A DOCTYPE is refused, apart from the reference to gama-local.dtd in old files, which is not
/// opened.
[[nodiscard]] Result<NetworkFile> read_gama(const std::string& path);

/// Reads a survey.yaml (schema/data/survey.json). Errors: kBadInput with the line.
[[nodiscard]] Result<NetworkFile> read_survey(const std::string& path);
/// Text of a survey.yaml whose adjustment equals that of the network.
[[nodiscard]] std::string survey_to_yaml(const NetworkFile& file);

}  // namespace octant::io
