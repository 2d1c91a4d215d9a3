// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to the track of a vehicle in space: arrivals as ranges, and a first place from them.

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/common/arrival_range.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/drive/space_track.h"

namespace octant {

/// An arrival as a distance.
struct SpaceRange {
  Arrival arrival;
  ArrivalRange distance;
  Eigen::Vector3d p_beacon_m;
  double variance_m2 = 0.0;  ///< white, with what the attitude may put the receiver off
  Rejection mark = Rejection::kUsed;
};

struct SpaceInstant {
  double time_s = 0.0;
  std::size_t first = 0, last = 0;  ///< its ranges
};

/// All that a vehicle's receivers, the site and its errors mean for the track.
struct SpaceSetting {
  const Deployment& deployment;
  const SpaceTrackOptions& options;
  CalibrationPart calibration;
  std::vector<int> bias;  ///< state of each beacon; -1: none
  Eigen::Index size = 6;
  double bias_sigma_m = 0.0, bias_time_s = 1.0;
  double lever_m2 = 0.0;  ///< variance of the origin's place in each axis about the receivers' centre
  double extent_m = 1.0;  ///< of the beacons
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  bool coplanar = false;  ///< the beacons, so that their plane leaves a mirror image
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< of that plane

  SpaceSetting(const Deployment& d, const SpaceTrackOptions& o);
};

/// SpaceRanges of a vehicle and their instants.
struct SpaceRanges {
  std::vector<SpaceRange> all;
  std::vector<SpaceInstant> instants;
};

/// @param setting  its lever_m2 is set to the vehicle's
[[nodiscard]] SpaceRanges ranges_in_space(const MeasurementLog& log, VehicleId vehicle,
                                          SpaceSetting& setting);

/// Place of the vehicle at an instant by what is heard in the next seconds, in stretches that grow until one
/// tells: robust Gauss-Newton from points around the beacons. None where fewer than three beacons are heard.
[[nodiscard]] std::optional<Eigen::Vector3d> place_in_space(const SpaceRanges& ranges, std::size_t instant,
                                                            const SpaceSetting& setting);

}  // namespace octant
