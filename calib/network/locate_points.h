// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/network/network.h"

namespace octant::calib {

struct LocatedNetwork {
  Network network;
  std::vector<std::string> computed;  ///< points with a coordinate that was computed
  std::vector<std::string> missing;   ///< points that the observations do not locate
};

/// Computes approximate coordinates where they are missing, from observations to points that have some: polar
/// points, intersections, resections, distances, vectors; heights from height differences and zenith angles.
/// Where no point can be computed (a traverse without orientation, a network without coordinates), points are
/// computed in a local frame and transformed by common points.
[[nodiscard]] LocatedNetwork locate_points(Network network);

}  // namespace octant::calib
