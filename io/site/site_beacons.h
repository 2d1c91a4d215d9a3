// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "models/support/result.h"

namespace octant::io {

/// A beacon to be written into a site file.
struct SiteBeaconEntry {
  std::string name;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double sigma_m = 0.1;
  std::optional<Eigen::Vector3d> axis;  ///< for the scene block's list of beacons
};

struct SiteBeaconsText {
  std::string text;
  std::vector<std::string> warnings;
};

/// Returns the text of a site file with other beacons. The beacons of the file stay (`keep`) or are removed,
/// the new ones follow them, and all other content except comments is unchanged. Control distances to removed
/// beacons are removed too, with a warning. Axes are written into the scene block if the file has one.
/// Errors: those of reading a site file, for the old text and for the new one.
/// @param path  of the file, for messages
[[nodiscard]] Result<SiteBeaconsText> with_beacons(std::string_view site_yaml, const std::string& path,
                                                   const std::vector<SiteBeaconEntry>& beacons, bool keep);

}  // namespace octant::io
