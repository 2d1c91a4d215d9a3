// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to the track of a vehicle in space: ranges of arrivals, and an initial position from them.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/common/arrival_range.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/space/space_track_options.h"
#include "models/run.h"

namespace octant {

/// An arrival as a distance.
struct SpaceRange {
  Arrival arrival;
  ArrivalRange distance;
  Eigen::Vector3d p_beacon_m;
  double variance_m2 = 0.0;  ///< white noise, including the unknown attitude of the lever arm
  double widening = 1.0;     ///< factor of its lasting error's sigma, see SpaceFilter::widen_tails()
  Rejection rejection = Rejection::kUsed;
};

struct SpaceInstant {
  double time_s = 0.0;
  std::int64_t epoch = kNoEpoch;
  std::size_t first = 0, last = 0;  ///< its ranges
};

/// Best-fitting plane of the beacons.
struct BeaconPlane {
  bool coplanar = false;  ///< true if positions have a mirror image
  double off_m = 0.0;     ///< root mean square distance of the beacons from it
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d across =
      Eigen::Vector3d::UnitX();  ///< in the plane, perpendicular to the best-fitting line

  [[nodiscard]] double height_m(const Eigen::Vector3d& p) const { return normal.dot(p - centre_m); }
  [[nodiscard]] Eigen::Vector3d mirrored(const Eigen::Vector3d& p) const {
    return p - 2 * height_m(p) * normal;
  }
};
/// Plane of the usable beacons of a deployment, optionally without one. @param extent_m  extent of all of
/// them
[[nodiscard]] BeaconPlane beacon_plane(const Deployment& deployment, double extent_m, BeaconId without = {});

/// Properties of the vehicle's receivers, the site and its errors that the track depends on.
struct SpaceSetting {
  const Deployment& deployment;
  const SpaceTrackOptions& options;
  CalibrationPart calibration;
  std::vector<int> bias;  ///< index of each beacon's bias in the state; -1: without bias
  Eigen::Index size = 6;
  double bias_sigma_m = 0.0, bias_time_s = 1.0;
  double range_sigma_m = 0.0;                                    ///< sigma of one range, including its bias
  Eigen::Vector3d p_centre_vehicle_m = Eigen::Vector3d::Zero();  ///< centre of the receivers
  double extent_m = 1.0;                                         ///< extent of the beacons
  double reach_m = 1.0;  ///< size of the space of motion: extent of the beacons, or median range
  bool in_line =
      /// True if the beacons are collinear within their accuracy, so that a vehicle may rotate about the line
      false;
  BeaconPlane plane;                 ///< plane of the beacons
  std::vector<double> off_plane_m2;  ///< calibration variance of each beacon's distance from the plane

  SpaceSetting(const Deployment& d, const SpaceTrackOptions& o);
};

/// Ranges of a vehicle, grouped by instant.
struct SpaceRanges {
  std::vector<SpaceRange> all;
  std::vector<SpaceInstant> instants;
};

/// @param setting  the centre of the receivers and the reach are set to the vehicle's
[[nodiscard]] SpaceRanges ranges_in_space(const MeasurementLog& log, VehicleId vehicle,
                                          SpaceSetting& setting);

/// Position at which a track begins, and its covariance for the first rejections.
struct SpaceStart {
  Eigen::Vector3d p_map_m;
  Eigen::Matrix3d covariance_m2;
};

/// Start of a track at a position of known accuracy.
[[nodiscard]] SpaceStart start_at(const Eigen::Vector3d& p_map_m, const Eigen::Matrix3d& information_per_m2,
                                  const SpaceSetting& setting);

/// Initial position of the vehicle at an instant from the ranges of the next seconds, over growing times
/// until it is unique: robust Gauss-Newton from points around the beacons. No value for fewer than three
/// beacons.
[[nodiscard]] std::optional<SpaceStart> place_in_space(const SpaceRanges& ranges, std::size_t instant,
                                                       const SpaceSetting& setting);

}  // namespace octant
