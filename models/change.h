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

/// What may have changed at a site between two visits.
enum class ChangeKind {
  kBeaconMoved,  ///< [m]; a control point that was knocked too
  kDelay,        ///< of a beacon [s]
  kReceiver,     ///< bent or moved on its vehicle [m]
  kSpeed,        ///< of the medium at the same temperature [m/s]
  kExchanged,    ///< two beacons at each other's places [m]
  kDatum,        ///< the whole map against what holds it [m]
  kAmplitude     ///< of a beacon, a factor [1]
};
/// As it stands in files: "beacon_moved", "delay", ...
[[nodiscard]] const char* to_string(ChangeKind kind);
[[nodiscard]] std::optional<ChangeKind> change_kind(std::string_view name);
/// Unit of its size: "m", "s", "m/s", "1".
[[nodiscard]] const char* unit_of(ChangeKind kind);

/// Subject of a delay that changed by the same for all beacons.
inline constexpr const char* kAllBeaconsSubject = "all beacons";

/// Something that is held to have changed.
struct Change {
  ChangeKind kind = ChangeKind::kBeaconMoved;
  std::string subject;  ///< "B3"; "robot/r3"; of exchanged beacons "B2, B5"; "speed"; "datum"; "all beacons"
  double size = 0.0;   ///< length of a move, distance of what was exchanged, new less old of delay and speed,
                       ///< factor of an amplitude
  double sigma = 0.0;  ///< of the size
  double p = 1.0;      ///< of so much by chance, after all that was tested
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< new less old, of what moved
  Eigen::Matrix3d shift_covariance_m2 = Eigen::Matrix3d::Zero();
};

/// Standard deviations by which everything may have drifted between two visits without being held to have
/// changed.
struct Drift {
  double beacon_m = 1.0e-3;  ///< per axis
  double delay_s = 3.0e-6;
  double receiver_m = 5.0e-4;  ///< per axis
  double speed_mps = 0.3;      ///< of the medium's offset at the same temperature
  double log_gain = 0.02;      ///< of each beacon's amplitude, ln
  double attenuation = 0.05;   ///< of amplitude, absorption and rise time of all, relative

  /// Of so many months: the defaults above, and in quadrature what grows with time as settling and ageing do:
  /// 0.1 mm, 0.3 us, 0.05 mm, 0.03 m/s, 0.5 % and 0.5 % a month.
  [[nodiscard]] static Drift of_months(double months);
};

/// Parameters of which nothing earlier was believed.
struct Released {
  std::vector<ParameterId> parameters;
  bool datum = false;  ///< the map as a whole
  friend bool operator==(const Released&, const Released&) = default;
};

/// Where a deployment comes from that was made of an earlier one and a second visit.
struct Previous {
  std::string sha256;   ///< of the earlier file
  std::string created;  ///< the earlier one, ISO 8601
  Drift drift;          ///< that was allowed for
  Released released;
  std::vector<Change> changes;  ///< as found
};

}  // namespace octant
