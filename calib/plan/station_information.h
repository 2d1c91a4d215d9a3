// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/problem/parameters.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// What is known of a site before the next stops are made: its shared parameters, where they stand, how well
/// they are known.
struct Knowledge {
  Problem problem;  ///< site; recordings stay behind
  ParameterLayout layout;
  SharedState state;
  Eigen::MatrixXd information;        ///< of priors and of all that was measured, on the layout's columns
  std::vector<bool> placed;           ///< beacons that have a place at which to expect them
  std::vector<double> place_sigma_m;  ///< of each beacon, its worst coordinate's
  double tof_sigma_s = 0.0;           ///< of an arrival
  std::vector<std::string> warnings;
};

/// From the site file alone: priors and control distances. A coordinate whose accuracy is not stated is taken
/// as known to four times the site's extent; beacons without a position are left out, with a warning. Errors
/// (kBadInput): no beacon has a position, no vehicle with receivers, no noise of arrivals.
[[nodiscard]] Result<Knowledge> knowledge_of(const Site& site);
/// From recordings that were solved. Errors (kBadInput): the solution carries no states.
[[nodiscard]] Result<Knowledge> knowledge_of(const Problem& problem, const Solution& solution,
                                             int threads = 1);
/// From a deployment: the inverse of its joint covariance. Errors as of a site; kBadInput without a joint
/// covariance.
[[nodiscard]] Result<Knowledge> knowledge_of(const Deployment& deployment);

/// Which beacons a receiver surely hears at a stop: range and angle are cut by twice what the beacon's place
/// is uncertain (by a tenth at most), so that no stop hangs on an arrival that will not come.
struct HearingModel {
  double range_m = std::numeric_limits<double>::infinity();  ///< beyond it nothing is heard
  double half_angle_rad = 4.0;  ///< between a receiver's axis and the beacon; pi and above: all round
  /// Whether walls and beams let it through besides; empty: they do.
  std::function<bool(BeaconId, ReceiverId, const Pose& T_map_vehicle)> also;
};

/// How far and how far off their axes the receivers of recordings heard: what 99.5 % of the arrivals that
/// were used keep within.
[[nodiscard]] HearingModel hearing_of(const Solution& solution, const Site& site);

/// One firing round heard at a stop.
struct StopModel {
  HearingModel hearing;
  VehicleId vehicle{std::size_t{0}};
  int firings = 1;        ///< how often each beacon fires at a stop
  double height_m = 0.0;  ///< of the vehicle frame; planar motion: 0
  /// Measured poses of the stops (a total station), if there are any.
  std::optional<PoseAccuracy> measured_poses;
};

/// What a stop says of the shared parameters once its own pose (and clock offset) is eliminated: rows A over
/// the columns it touches, so that its information is A'A = Js'Js - Js'Jx (Jx'Jx)^-1 Jx'Js.
struct StopRows {
  std::vector<int> columns;           ///< of the layout, ascending
  Eigen::MatrixXd A;                  ///< rows by columns
  std::vector<std::size_t> arrivals;  ///< by beacon
  std::size_t arrival_count = 0;
};
/// Expected rows of a stop at x, y with a heading; no rows where the arrivals do not tell its pose.
[[nodiscard]] StopRows stop_rows(const Knowledge& knowledge, const Eigen::Vector2d& position_m,
                                 double heading_rad, const StopModel& model);

/// Adds A'A to an information matrix of the layout.
void add_information(const StopRows& rows, Eigen::MatrixXd& information, double factor = 1.0);

}  // namespace octant::calib
