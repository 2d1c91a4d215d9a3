// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/fix.h"

namespace octant::survey {

/// Half axes of a 95 % error ellipse in sigmas: the square root of chi-square's 0.95 quantile, 2 degrees of freedom.
inline constexpr double kEllipse95 = 2.4477;

/// Where a vehicle was, in the map: stations of a stop-and-go run, or the course of a drive.
struct Track {
  bool moving = false;
  std::vector<Eigen::Vector2d> points_m;
};

/// What is drawn on the plan.
struct PlanInput {
  Deployment deployment;
  std::vector<Track> tracks;  ///< of the calibration
  std::vector<Fix> fixes;     ///< of a run that was localized; may be empty
};

/// By how much error ellipses are drawn larger than they are, so that the largest is some 5 % of the plan: 1, 2 or 5 times a
/// power of ten, at least 1.
[[nodiscard]] double ellipse_exaggeration(const Deployment& deployment, double plan_extent_m);

/// Plan of a site as a self-contained SVG: grid in metres, calibrated area, tracks, fixes, beacons with exaggerated 95 % error
/// ellipses and a legend that says by how much. Follows the reader's light or dark scheme. Undetermined beacons are not drawn:
/// their place is not known.
[[nodiscard]] std::string site_plan_svg(const PlanInput& input);

/// Text made safe for XML and HTML, in content and in quoted attributes.
[[nodiscard]] std::string escape_xml(const std::string& text);

}  // namespace octant::survey
