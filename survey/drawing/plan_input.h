// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"

namespace octant::survey {

/// Half axes of a 95 % error ellipse in sigmas: the square root of chi-square's 0.95 quantile, 2 degrees of
/// freedom.
inline constexpr double kEllipse95 = 2.4477;

/// Positions of a vehicle in the map: stops of a stop-and-go run, or the course of a drive.
struct Track {
  bool moving = false;
  std::vector<Eigen::Vector3d> points_m;
  std::size_t thinned_from = 0;  ///< number of points before thinning; 0: not thinned
};

/// A quantity over the site on a regular grid; a plan shows one grid at a time.
struct NamedMap {
  std::string name;                ///< "HDOP", "expected error of a fix"
  std::string unit;                ///< "mm"; empty: a ratio
  Eigen::Vector2d corner_m{0, 0};  ///< lower left corner of the first cell
  double cell_m = 1.0;
  std::size_t columns = 0;
  std::vector<double> values;    ///< row by row from below; NaN: no value; infinity: no fix
  std::string silent_beacon{};   ///< crossed out while this map is shown
  std::vector<double> limits{};  ///< between classes, where several maps are to be compared; empty: its own
  std::optional<double> tolerance{};  ///< colours say where the values lie against it: inside, near, beyond
};

/// A line of the place with its name: a wall, an obstacle's outline, a route.
struct NamedLine {
  std::string name;
  std::vector<Eigen::Vector2d> points_m;
  bool closed = false;
};

/// Shift of a beacon since an earlier deployment.
struct PlanMove {
  std::string beacon;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< new less old
};

/// Arrivals of a beacon that were left out while the vehicle stood (or drove) at a place.
struct PlanMiss {
  std::string beacon;
  Eigen::Vector2d at_m{0, 0};  ///< position of the vehicle
  std::size_t late = 0, early = 0, other = 0;
  [[nodiscard]] std::size_t count() const { return late + early + other; }
};

/// Content of a plan.
struct PlanInput {
  Deployment deployment;
  std::vector<Track> tracks;             ///< trajectories of the calibration
  std::vector<Eigen::Vector3d> fixes_m;  ///< fixes of a localized run; may be empty
  std::vector<NamedMap> maps;
  std::vector<PlanMove> moves{};   ///< arrows to where beacons hang now
  std::vector<PlanMiss> misses{};  ///< lines from the vehicle to the beacon
  std::vector<NamedLine> walls{}, routes{};
  std::string area_name = "calibrated area", beacon_name = "calibrated beacon";  ///< as legends call them
};

}  // namespace octant::survey
