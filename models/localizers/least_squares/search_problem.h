// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/support/scratch.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Planar pose under test. The cycle offset is in metres, so that all unknowns have a similar scale.
struct PlanarState {
  double x_m = 0.0;
  double y_m = 0.0;
  double heading_rad = 0.0;
  double offset_m = 0.0;
};

/// An arrival reduced to geometry: |T lever - beacon| (+ offset) = range.
struct SearchRange {
  Eigen::Vector3d p_beacon_map_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_lever_m = Eigen::Vector3d::Zero();  ///< receiver in the frame of the pose
  Eigen::Vector2d axis = Eigen::Vector2d::Zero();  ///< horizontal axis in that frame; zero: omnidirectional
  double hearing_cosine =
      kHearingCosine;  ///< limit of the cosine off the axis, beyond which reception is unlikely
  double range_m = 0.0;
  double sigma_m = 0.0;
  BeaconId beacon;
  std::size_t observation = 0;  ///< index into Trajectory::arrivals
};

struct SearchBearing {
  Eigen::Vector2d p_reflector_map_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d p_lever_m = Eigen::Vector2d::Zero();  ///< sensor in the frame of the pose
  double bearing_rad = 0.0;                             ///< in that frame
  double sigma_rad = 0.01;
};

/// Input of the search for a pose. Delays, speed and time-walk are removed beforehand, so that a candidate
/// costs one square root for each arrival.
struct SearchProblem {
  std::pmr::vector<SearchRange> ranges{scratch()};  ///< sorted by beacon
  std::pmr::vector<std::size_t> group_first{
      scratch()};  ///< first range of each beacon, and one past the last
  std::pmr::vector<double> group_bias_m{
      scratch()};  ///< common sigma of each beacon's ranges: uncertainty and calibration
  std::pmr::vector<SearchBearing> bearings{scratch()};
  bool has_offset = false;
  /// True within a stationary epoch: the arrivals of one beacon share its position error and the detour of a
  /// shadow.
  bool common_bias = true;
  double uncertainty_m = 0.0;
  double speed_mps = 1.0;  ///< speed that converted the times, of the middle arrival
  double span_m = 1.0;     ///< longest range
  double lever_m = 0.0;    ///< longest horizontal lever arm
  double median_sigma_m = 0.0;

  [[nodiscard]] std::size_t groups() const { return group_first.empty() ? 0 : group_first.size() - 1; }
  /// Returns true if the data determine the heading: by a lever arm that is significant against the noise, an
  /// axis, or a bearing.
  [[nodiscard]] bool sees_heading() const { return lever_m > 1e-6 || !bearings.empty(); }
};

/// Poses of a part of the odometry relative to its anchor, and their drift.
struct RigidPath {
  std::size_t first_node = 0;
  std::pmr::vector<Pose> T_anchor_node{scratch()};  ///< empty: all observations refer to the anchor itself
  std::pmr::vector<double> drift_m{scratch()};      ///< sigma for each node
};

/// Reduces the usable arrivals and bearings of a segment. Two-way paths get the mean of both lever arms; the
/// remaining curvature is left to the adjustment.
[[nodiscard]] SearchProblem make_search_problem(const Trajectory& trajectory, const Segment& segment,
                                                const EpochFixModel& model, double range_uncertainty_m,
                                                const RigidPath& path = {});

}  // namespace octant
