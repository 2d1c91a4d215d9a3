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

/// Planar pose under test. The cycle offset is in metres, so that all unknowns of the search are of one size.
struct PlanarState {
  double x_m = 0.0;
  double y_m = 0.0;
  double heading_rad = 0.0;
  double offset_m = 0.0;
};

/// An arrival reduced to geometry: |T lever - beacon| (+ offset) = range.
struct SearchRange {
  Eigen::Vector3d p_beacon_map_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_lever_m = Eigen::Vector3d::Zero();  ///< receiver in the frame that is searched for
  Eigen::Vector2d axis =
      Eigen::Vector2d::Zero();             ///< horizontal direction of hearing in that frame; zero: all round
  double hearing_cosine = kHearingCosine;  ///< what lies further off the axis is hardly heard
  double range_m = 0.0;
  double sigma_m = 0.0;
  BeaconId beacon;
  std::size_t observation = 0;  ///< index into Trajectory::arrivals
};

struct SearchBearing {
  Eigen::Vector2d p_reflector_map_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d p_lever_m = Eigen::Vector2d::Zero();  ///< sensor in the frame that is searched for
  double bearing_rad = 0.0;                             ///< in that frame
  double sigma_rad = 0.01;
};

/// What the search for a pose looks at: delays, speed and time-walk are taken out beforehand, so that a
/// candidate costs a square root an arrival.
struct SearchProblem {
  std::pmr::vector<SearchRange> ranges{scratch()};  ///< sorted by beacon
  std::pmr::vector<std::size_t> group_first{
      scratch()};  ///< first range of each beacon, and one past the last
  std::pmr::vector<double> group_bias_m{
      scratch()};  ///< sigma of what each beacon's ranges are off by together: uncertainty and calibration
  std::pmr::vector<SearchBearing> bearings{scratch()};
  bool has_offset = false;
  /// Arrivals of one beacon share its error of position and an obstacle's detour: true within a stationary
  /// epoch.
  bool common_bias = true;
  double uncertainty_m = 0.0;
  double speed_mps = 1.0;  ///< by which times became ranges, of the middle arrival
  double span_m = 1.0;     ///< longest range
  double lever_m = 0.0;    ///< longest horizontal lever arm
  double median_sigma_m = 0.0;

  [[nodiscard]] std::size_t groups() const { return group_first.empty() ? 0 : group_first.size() - 1; }
  /// The data tell the heading: a lever arm that counts against the noise, an axis, or a bearing.
  [[nodiscard]] bool sees_heading() const { return lever_m > 1e-6 || !bearings.empty(); }
};

/// The frames of a stretch of odometry in the frame of its anchor, and how far they may have drifted.
struct RigidPath {
  std::size_t first_node = 0;
  std::pmr::vector<Pose> T_anchor_node{scratch()};  ///< empty: all observations are of the anchor itself
  std::pmr::vector<double> drift_m{scratch()};      ///< sigma, one for each node
};

/// Reduces the usable arrivals and bearings of a segment. Two-way paths get the mean of both lever arms:
/// their curvature is left to the adjustment that follows.
[[nodiscard]] SearchProblem make_search_problem(const Trajectory& trajectory, const Segment& segment,
                                                const EpochFixModel& model, double range_uncertainty_m,
                                                const RigidPath& path = {});

}  // namespace octant
