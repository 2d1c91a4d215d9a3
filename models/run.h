// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "models/ids.h"
#include "models/physics/pose.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant {

inline constexpr std::int64_t kNoEpoch = std::numeric_limits<std::int64_t>::min();

/// Time of flight between a beacon and a receiver.
struct Arrival {
  double time_s = 0.0;  ///< time at the vehicle's end of the path
  double tof_s = 0.0;
  BeaconId beacon;
  ReceiverId receiver;
  VehicleId vehicle;
  std::int64_t epoch = kNoEpoch;
  double amplitude_v = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not logged
  double temperature_degC =
      std::numeric_limits<double>::quiet_NaN();  ///< NaN: temperature of the run or of the site
  int line = 0;                                  ///< row in tof.csv
  /// Time from time_s until the row was received [s]; NaN: not logged.
  float received_after_s = std::numeric_limits<float>::quiet_NaN();
};

/// Builds an arrival from names, for a robot's own program. Errors: an unknown name, or no receiver although
/// the vehicle has several.
[[nodiscard]] Result<Arrival> arrival_of(const NameTable& names, std::string_view beacon, double tof_s,
                                         double time_s = 0.0, std::string_view receiver = {},
                                         std::string_view vehicle = {});

/// Direction of a reflector in the vehicle frame, counter-clockwise from +x.
struct Bearing {
  double time_s = 0.0;
  double bearing_rad = 0.0;
  BeaconId reflector;  ///< not valid(): unlabelled
  VehicleId vehicle;
  std::int64_t epoch = kNoEpoch;
  int line = 0;
};

/// Pose of this row relative to the previous row; the first row is the anchor. In space the rotation is the
/// vector (turn_x_rad, turn_y_rad, dheading_rad); in the plane only the last component is used.
struct OdometryStep {
  double time_s = 0.0;
  double dx_m = 0.0;
  double dy_m = 0.0;
  double dheading_rad = 0.0;
  VehicleId vehicle;
  double dz_m = 0.0;
  double turn_x_rad = 0.0, turn_y_rad = 0.0;
  double way_m =
      0.0;  ///< path length of the rows that a long step combines; 0: a single row, whose path is its chord

  [[nodiscard]] bool is_planar() const { return dz_m == 0.0 && turn_x_rad == 0.0 && turn_y_rad == 0.0; }
  [[nodiscard]] bool is_zero() const {
    return dx_m == 0.0 && dy_m == 0.0 && dheading_rad == 0.0 && is_planar();
  }
  [[nodiscard]] bool is_finite() const {
    return std::isfinite(dx_m) && std::isfinite(dy_m) && std::isfinite(dz_m) && turn_rad().allFinite();
  }
  [[nodiscard]] Eigen::Vector3d turn_rad() const { return {turn_x_rad, turn_y_rad, dheading_rad}; }
  [[nodiscard]] Pose pose() const {
    return is_planar() ? Pose::planar(dx_m, dy_m, dheading_rad)
                       : Pose{{dx_m, dy_m, dz_m}, exp_rotation(turn_rad())};
  }
  void set_pose(const Pose& T_before_after) {
    const Eigen::Vector3d& d = T_before_after.translation_m;
    const Eigen::Vector3d turn = log_rotation(T_before_after.rotation);
    dx_m = d.x(), dy_m = d.y(), dz_m = d.z();
    turn_x_rad = turn.x(), turn_y_rad = turn.y(), dheading_rad = turn.z();
  }
};

struct TimedPose {
  double time_s = 0.0;
  Pose T_map_vehicle;
};

struct Scan {
  double time_s = 0.0;
  double angle_min_rad = 0.0;
  double angle_increment_rad = 0.0;
  std::vector<double> range_m;  ///< NaN: no echo
};

/// Accuracy of measured poses or of a reference trajectory; sigma 0 is exact.
struct PoseAccuracy {
  double position_sigma_m = 0.01;
  double heading_sigma_rad = 0.01;  ///< ignored when heading_known is false
  bool heading_known = true;
  double attitude_sigma_rad = 0.01;  ///< roll and pitch; equal to the heading's sigma if not given
  double max_gap_s = 1.0;            ///< longest gap over which poses are interpolated [s]
};

/// Odometry noise over a step of length d and turn a:
///   sigma_xy^2 = distance^2 d + floor_m^2,  sigma_heading^2 = heading^2 d + (per_rad a)^2 + floor_rad^2
struct OdometryAccuracy {
  double distance_sigma_m_per_sqrt_m = 0.02;
  double heading_sigma_rad_per_sqrt_m = 0.02;
  double heading_sigma_per_rad = 0.0;
  double floor_m = 1.0e-4;
  double floor_rad = 1.0e-4;
};

/// A row that is not a valid measurement, with the reason ("tof_s is not a number").
struct RejectedRow {
  int line = 0;
  std::string reason;
};

/// One recording: the contents of a run folder, row by row, with names resolved to ids.
struct MeasurementLog {
  std::string path;  ///< folder, as the user wrote it
  std::vector<Arrival> arrivals;
  std::vector<Bearing> bearings;
  std::vector<OdometryStep> odometry;
  std::vector<TimedPose> poses;  ///< measured poses, used as observations
  std::vector<TimedPose> truth;  ///< reference trajectory; read only on request (verify)
  std::vector<Scan> scans;
  VehicleId vehicle;  ///< vehicle of rows that name none, and of poses.tum
  std::optional<double> temperature_degC;
  std::optional<double> relative_humidity;
  std::optional<double> pressure_pa;
  PoseAccuracy pose_accuracy;
  /// Exact unless run.yaml states otherwise. This can only overstate the errors of the fixes.
  PoseAccuracy truth_accuracy = {
      .position_sigma_m = 0.0, .heading_sigma_rad = 0.0, .attitude_sigma_rad = 0.0};
  OdometryAccuracy odometry_accuracy;
  bool has_epochs = false;  ///< tof.csv or bearings.csv has an epoch column
  std::size_t rows = 0;     ///< number of data rows in tof.csv, including rejected ones
  std::vector<RejectedRow> rejected;
  std::vector<std::string> warnings;
  std::map<std::string, std::string> sha256;  ///< digest of each file that was read, by path
};

}  // namespace octant
