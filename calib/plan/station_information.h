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

/// Knowledge of a site before the next stops: its shared parameters, their values, their covariance.
struct Knowledge {
  Problem problem;  ///< site; recordings stay behind
  ParameterLayout layout;
  SharedState state;
  Eigen::MatrixXd information;  ///< information of priors and measurements, in the columns of the layout
  std::vector<bool> placed;     ///< beacons that have a place at which to expect them
  std::vector<double> place_sigma_m;  ///< largest sigma of a coordinate of each beacon
  double tof_sigma_s = 0.0;           ///< sigma of an arrival
  std::vector<std::string> warnings;
};

/// Knowledge from the site file only: priors and control distances. A coordinate without a stated accuracy is
/// assumed to be known to four times the site's extent; beacons without a position are left out, with a
/// warning. Errors (kBadInput): no beacon has a position, no vehicle with receivers, no noise of arrivals.
[[nodiscard]] Result<Knowledge> knowledge_of(const Site& site);
/// From recordings that were solved. Errors (kBadInput): the solution carries no states.
[[nodiscard]] Result<Knowledge> knowledge_of(const Problem& problem, const Solution& solution,
                                             int threads = 1);
/// From a deployment: the inverse of its joint covariance. Errors as of a site; kBadInput without a joint
/// covariance.
[[nodiscard]] Result<Knowledge> knowledge_of(const Deployment& deployment);

/// Determines the beacons that a receiver certainly receives at a stop. Range and angle are reduced by twice
/// the uncertainty of the beacon's position (by a tenth at most), so that no stop depends on an arrival that
/// does not come.
struct HearingModel {
  double range_m = std::numeric_limits<double>::infinity();  ///< largest range of reception
  double half_angle_rad = 4.0;  ///< between a receiver's axis and the beacon; pi and above: all round
  /// Additional test by walls and patterns; empty: no restriction.
  std::function<bool(BeaconId, ReceiverId, const Pose& T_map_vehicle)> also;
};

/// Range and angle off the axis within which receivers of recordings received: 99.5 % of the used arrivals.
[[nodiscard]] HearingModel hearing_of(const Solution& solution, const Site& site);

/// One firing round received at a stop.
struct StopModel {
  HearingModel hearing;
  VehicleId vehicle{std::size_t{0}};
  int firings = 1;        ///< number of times that each beacon fires at a stop
  double height_m = 0.0;  ///< height of the vehicle frame; planar motion: 0
  /// Measured poses of the stops (a total station), if there are any.
  std::optional<PoseAccuracy> measured_poses;
};

/// Information of a stop on the shared parameters after the elimination of its own pose (and clock offset):
/// rows A over its columns, so that the information is A'A = Js'Js - Js'Jx (Jx'Jx)^-1 Jx'Js.
struct StopRows {
  std::vector<int> columns;           ///< columns of the layout, ascending
  Eigen::MatrixXd A;                  ///< rows by columns
  std::vector<std::size_t> arrivals;  ///< by beacon
  std::size_t arrival_count = 0;
};
/// Expected rows of a stop at x, y with a heading; no rows if the arrivals do not determine where its
/// receivers are.
[[nodiscard]] StopRows stop_rows(const Knowledge& knowledge, const Eigen::Vector2d& position_m,
                                 double heading_rad, const StopModel& model);

/// Adds A'A to an information matrix of the layout.
void add_information(const StopRows& rows, Eigen::MatrixXd& information, double factor = 1.0);

}  // namespace octant::calib
