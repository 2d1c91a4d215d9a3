// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "models/parameter.h"

namespace octant {

/// Kinds of change that a second visit to a site can find.
enum class ChangeKind {
  kBeaconMoved,  ///< position of a beacon or of a control point [m]
  kDelay,        ///< delay of a beacon [s]
  kReceiver,     ///< position of a receiver on its vehicle [m]
  kSpeed,        ///< speed of the medium at a given temperature [m/s]
  kExchanged,    ///< positions of two beacons swapped [m]
  kDatum,        ///< pose of the whole map relative to its control [m]
  kAmplitude     ///< amplitude of a beacon, as a factor [1]
};
/// Name used in files: "beacon_moved", "delay", ...
[[nodiscard]] const char* to_string(ChangeKind kind);
[[nodiscard]] std::optional<ChangeKind> change_kind(std::string_view name);
/// Unit of Change::size: "m", "s", "m/s" or "1".
[[nodiscard]] const char* unit_of(ChangeKind kind);

/// Subject of a delay that changed by the same amount for all beacons.
inline constexpr const char* kAllBeaconsSubject = "all beacons";

/// A change that passed the significance test.
struct Change {
  ChangeKind kind = ChangeKind::kBeaconMoved;
  std::string subject;  ///< "B3", "robot/r3", "speed", "datum" or "all beacons"; for swapped beacons "B2, B5"
  double size = 0.0;    ///< length of a move, distance between swapped beacons, new minus old delay or speed,
                        ///< or factor of an amplitude
  double sigma = 0.0;   ///< standard deviation of `size`
  double p = 1.0;       ///< probability of a change this large by chance, corrected for the number of tests
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< new minus old position
  Eigen::Matrix3d shift_covariance_m2 = Eigen::Matrix3d::Zero();
};

/// Standard deviations of the drift that is expected between two visits and is not reported as a change.
struct Drift {
  double beacon_m = 1.0e-3;  ///< each axis
  double delay_s = 3.0e-6;
  double receiver_m = 5.0e-4;  ///< each axis
  double speed_mps = 0.3;      ///< offset of the medium's speed at a given temperature
  double log_gain = 0.02;      ///< natural logarithm of each beacon's amplitude
  double attenuation = 0.05;   ///< common amplitude, absorption and rise time, relative
};

/// Parameters for which the earlier calibration was not used as a prior.
struct Released {
  std::vector<ParameterId> parameters;
  bool datum = false;  ///< pose of the whole map
  friend bool operator==(const Released&, const Released&) = default;
};

/// Origin of a deployment that was made from an earlier one and a second visit.
struct Previous {
  std::string sha256;   ///< digest of the earlier file
  std::string created;  ///< creation time of the earlier deployment, ISO 8601
  Drift drift;          ///< drift that was allowed for
  Released released;
  std::vector<Change> changes;  ///< changes that were found
};

}  // namespace octant
