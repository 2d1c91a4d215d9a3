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

/// How the simulated vehicle goes.
enum class PathKind {
  kStops,      ///< stationary epochs along a closed Lissajous path through the hall
  kWaypoints,  ///< stationary epochs evenly along a polyline
  kStations,   ///< stationary epochs at given poses, one after the other, round and round
  kDrive       ///< continuous drive between random goals, or round the waypoints where they are given, with
               ///< odometry
};

/// A world to simulate: the truth that the site file does not know, drawn from the priors that it states.
/// The site's first vehicle is the one that moves.
struct Scenario {
  /// What people would write, but its beacons stand at their TRUE positions. sigma_m is what they are known
  /// to: World::site gets truth plus noise; 0 is a control point, exactly true; no sigma means that nobody
  /// knows the coordinate. The lengths of control distances are measured anew.
  Site site;
  std::array<double, 2> hall_m = {20.0, 12.0};  ///< floor, from the origin
  struct Path {
    PathKind kind = PathKind::kStops;
    int epochs = 120;
    double epoch_period_s = 5.0;
    double slot_s = 0.05;       ///< between the firings of two beacons
    int rounds = 1;             ///< how often each beacon fires in an epoch
    double duration_s = 120.0;  ///< of a drive
    double speed_mps = 0.6;
    double turn_rate_rad_per_s = 0.7;
    double odometry_period_s = 0.05;  ///< of a drive's odometry, truth and measured poses
    std::vector<Eigen::Vector2d> waypoints_m;
    std::vector<Eigen::Vector3d> stations;  ///< x [m], y [m], heading [rad]
  } path, heldout_path;                     ///< of the calibration run and of the held-out run
  double range_m = 12.0;                    ///< beyond it nothing is heard
  double hearing_half_angle_rad = 3.2;      ///< of receivers with an axis; above pi: all round
  double echo_fraction =
      0.0;  ///< arrivals that are late, half of them because a beacon is shadowed for the whole epoch
  std::array<double, 2> echo_delay_s = {0.3e-3, 12.0e-3};  ///< log-uniform
  double early_fraction = 0.0;                             ///< spurious early arrivals
  double quantum_s = 0.0;                                  ///< resolution of the counter; 0: none
  /// How far the true speed is off: as stated; else as the true temperature less the stated one makes it;
  /// else drawn from the site's prior, clipped to two sigma.
  std::optional<double> true_speed_offset_mps;
  std::optional<double> true_temperature_offset_degC;
  double warming_degC = 0.0;  ///< temperature column rising by this much along the run; 0: no column
  std::optional<std::array<double, 2>>
      true_delay_s;  ///< true delays, uniform between; else drawn from the site's prior
  std::array<double, 2> cycle_offset_s = {0.0,
                                          0.05};  ///< Clock::kCycleOffset: uniform between, new each epoch
  bool unknown_beacons = false;  ///< World::site knows nothing of beacons that are no control points
  bool log_amplitude = false;    ///< write the amplitude column
  bool log_poses = false;        ///< write measured poses (poses.tum) with pose_accuracy
  PoseAccuracy pose_accuracy;
  bool log_odometry = false;  ///< of a drive in space as well; of one in the plane it is always written
  OdometryAccuracy odometry_accuracy = {.distance_sigma_m_per_sqrt_m = 0.01,
                                        .heading_sigma_rad_per_sqrt_m = 0.0087};
  /// Bearings to the site's beacons, which then are reflectors; noise.bearing_sigma_rad. Once a stop, or
  /// along a drive.
  struct Bearings {
    double range_m = 1e6;              ///< beyond it a reflector is not seen
    double unlabelled_fraction = 0.0;  ///< of bearings without a reflector's name
    double period_s = 0.5;             ///< of a drive
  };
  std::optional<Bearings> bearings;
  /// Laser scans of the walls, from the vehicle frame's origin; noise.range_sigma_m. Once a stop, or along a
  /// drive.
  struct Scans {
    double period_s = 0.5;  ///< of a drive
    double angle_min_rad = -1.5707963267948966;
    double angle_increment_rad = 0.017453292519943295;
    int beams = 181;
    double range_max_m = 30.0;
  };
  std::optional<Scans> scans;
  std::vector<std::array<double, 4>>
      walls_m;  ///< x1, y1, x2, y2 of each; they stop beams, but neither sound nor bearings
  std::vector<std::string> warnings;
};

}  // namespace octant
