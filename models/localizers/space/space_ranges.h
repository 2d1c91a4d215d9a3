// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to the track of a vehicle in space: arrivals as ranges, and a first place from them.

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
  double variance_m2 = 0.0;  ///< white, with what the attitude may put the receiver off
  Rejection rejection = Rejection::kUsed;
};

struct SpaceInstant {
  double time_s = 0.0;
  std::int64_t epoch = kNoEpoch;
  std::size_t first = 0, last = 0;  ///< its ranges
};

/// The plane that beacons lie in, or come nearest to.
struct BeaconPlane {
  bool coplanar = false;  ///< so that it leaves a mirror image
  double off_m = 0.0;     ///< of the beacons from it, root of the mean square
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d across =
      Eigen::Vector3d::UnitX();  ///< in the plane, across the line that comes nearest to them

  [[nodiscard]] double height_m(const Eigen::Vector3d& p) const { return normal.dot(p - centre_m); }
};
/// Of the usable beacons of a deployment but one. @param extent_m  of all of them
[[nodiscard]] BeaconPlane beacon_plane(const Deployment& deployment, double extent_m, BeaconId without = {});

/// All that a vehicle's receivers, the site and its errors mean for the track.
struct SpaceSetting {
  const Deployment& deployment;
  const SpaceTrackOptions& options;
  CalibrationPart calibration;
  std::vector<int> bias;  ///< state of each beacon; -1: none
  Eigen::Index size = 6;
  double bias_sigma_m = 0.0, bias_time_s = 1.0;
  double range_sigma_m = 0.0;                                    ///< of one range, its bias included
  Eigen::Vector3d p_centre_vehicle_m = Eigen::Vector3d::Zero();  ///< of the receivers
  double extent_m = 1.0;                                         ///< of the beacons
  double reach_m = 1.0;  ///< of what the vehicle moves in: the beacons' extent, or its median range
  bool in_line =
      false;          ///< the beacons, as well as their places are known: a vehicle may turn about the line
  BeaconPlane plane;  ///< of the beacons
  std::vector<double> off_plane_m2;  ///< variance of each beacon's distance from the plane by the calibration

  SpaceSetting(const Deployment& d, const SpaceTrackOptions& o);
};

/// SpaceRanges of a vehicle and their instants.
struct SpaceRanges {
  std::vector<SpaceRange> all;
  std::vector<SpaceInstant> instants;
};

/// @param setting  the centre of the receivers and the reach are set to the vehicle's
[[nodiscard]] SpaceRanges ranges_in_space(const MeasurementLog& log, VehicleId vehicle,
                                          SpaceSetting& setting);

/// Place of the vehicle at an instant by what is heard in the next seconds, in stretches that grow until one
/// tells: robust Gauss-Newton from points around the beacons. None where fewer than three beacons are heard.
[[nodiscard]] std::optional<Eigen::Vector3d> place_in_space(const SpaceRanges& ranges, std::size_t instant,
                                                            const SpaceSetting& setting);

}  // namespace octant
