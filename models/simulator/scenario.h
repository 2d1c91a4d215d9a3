// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/run.h"
#include "models/site.h"

namespace octant {

/// Motion of the simulated vehicle.
enum class PathKind {
  kStops,      ///< stationary epochs along a closed Lissajous path through the hall
  kWaypoints,  ///< stationary epochs evenly along a polyline
  kStations,   ///< stationary epochs at given poses, repeated in order
  kDrive       ///< continuous drive between random goals, or around the given waypoints, with odometry
};

/// A world to simulate. True values that the site file leaves open are drawn from its priors. The first
/// vehicle of the site moves.
struct Scenario {
  /// The site file as a user would write it, except that its beacons are at their TRUE positions. World::site
  /// gets these positions plus noise of sigma_m. sigma_m 0 is a control point with its exact position, no
  /// sigma an unknown coordinate. Control distances are measured again.
  Site site;
  std::array<double, 2> hall_m = {20.0, 12.0};  ///< size of the floor, from the origin
  struct Path {
    PathKind kind = PathKind::kStops;
    int epochs = 120;
    double epoch_period_s = 5.0;
    double slot_s = 0.05;       ///< time between the firings of two beacons
    int rounds = 1;             ///< number of firings of each beacon in an epoch
    double duration_s = 120.0;  ///< length of a drive
    double speed_mps = 0.6;
    double turn_rate_rad_per_s = 0.7;
    double odometry_period_s = 0.05;  ///< period of odometry, truth and measured poses of a drive
    std::vector<Eigen::Vector2d> waypoints_m;
    std::vector<Eigen::Vector3d> stations;  ///< x [m], y [m], heading [rad]
  } path, heldout_path;                     ///< paths of the calibration run and of the validation run
  double range_m = 12.0;                    ///< maximum range of reception
  double hearing_half_angle_rad = 3.2;      ///< limit for receivers with an axis; above pi: omnidirectional
  double echo_fraction =
      0.0;  ///< share of late arrivals; half of them because a beacon is shadowed for the whole epoch
  std::array<double, 2> echo_delay_s = {0.3e-3, 12.0e-3};  ///< bounds of a log-uniform distribution
  double early_fraction = 0.0;                             ///< share of spurious early arrivals
  double quantum_s = 0.0;                                  ///< resolution of the counter; 0: none
  /// Error of the stated speed. If not given, it follows from the error of the stated temperature; else it is
  /// drawn from the site's prior, clipped to two sigma.
  std::optional<double> true_speed_offset_mps;
  std::optional<double> true_temperature_offset_degC;
  double warming_degC = 0.0;  ///< increase of the temperature column along the run; 0: no column
  std::optional<std::array<double, 2>> true_delay_s;  ///< bounds of the uniformly distributed true delays;
                                                      ///< default: drawn from the site's prior
  std::array<double, 2> cycle_offset_s = {
      0.0, 0.05};                ///< Clock::kCycleOffset: bounds of the uniform offset, drawn for each epoch
  bool unknown_beacons = false;  ///< World::site has no positions of beacons other than control points
  bool log_amplitude = false;    ///< write the amplitude column
  bool log_poses = false;        ///< write measured poses (poses.tum) with pose_accuracy
  PoseAccuracy pose_accuracy;
  bool log_odometry = false;  ///< write odometry of a spatial drive; that of a planar drive is always written
  OdometryAccuracy odometry_accuracy = {.distance_sigma_m_per_sqrt_m = 0.01,
                                        .heading_sigma_rad_per_sqrt_m = 0.0087};
  /// Bearings to the site's beacons, which then act as reflectors, with noise.bearing_sigma_rad. Once for
  /// each stop, or periodically along a drive.
  struct Bearings {
    double range_m = 1e6;              ///< maximum distance of a reflector
    double unlabelled_fraction = 0.0;  ///< share of bearings without a reflector's name
    double period_s = 0.5;             ///< period along a drive
  };
  std::optional<Bearings> bearings;
  /// Laser scans of the walls from the vehicle's origin, with noise.range_sigma_m. Once for each stop, or
  /// periodically along a drive.
  struct Scans {
    double period_s = 0.5;  ///< period along a drive
    double angle_min_rad = -1.5707963267948966;
    double angle_increment_rad = 0.017453292519943295;
    int beams = 181;
    double range_max_m = 30.0;
  };
  std::optional<Scans> scans;
  std::vector<std::array<double, 4>>
      walls_m;  ///< x1, y1, x2, y2 of each wall; walls stop laser beams, but neither sound nor bearings
  std::vector<std::string> warnings;
};

}  // namespace octant
