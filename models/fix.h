// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/ids.h"
#include "models/physics/pose.h"
#include "models/run.h"

namespace octant {

enum class FixStatus {
  kOk,
  kTooFewArrivals,  ///< fewer arrivals than unknowns
  kPoorGeometry,    ///< the arrivals do not determine the pose
  kAmbiguous,       ///< two poses explain the arrivals equally well
  kNoConsensus,     ///< too many arrivals disagree
  kNotConverged
};
[[nodiscard]] const char* to_string(FixStatus status);

/// Reason for which an arrival was left out of a fix or of a calibration.
enum class Rejection : std::uint8_t {
  kUsed = 0,
  kLate,            ///< later than the pose explains: an echo
  kEarly,           ///< earlier than the pose explains: a spurious detection
  kBeaconUnusable,  ///< its beacon is undetermined
  kNoPose,          ///< no vehicle state at the time of the arrival
  kTriangle,        ///< farther than the triangle inequality with another beacon allows (Kleeman, eq. 5-6)
  kOutOfRange,      ///< outside the possible ranges of the site (Chang, rule 1)
  kReflection,      ///< second arrival of a beacon right after its first (Chang, rule 2)
  kOutvoted,        ///< fixes with this arrival disagree with the others (longsolve of Kleeman, four times of
                    ///< Thamma)
  kNotNeeded,       ///< not used by the method, which fixes the pose from other arrivals
  kUnknownId,       ///< beacon or receiver that is not part of the deployment
  kBeaconFault      ///< all arrivals of its beacon together contradict those of the other beacons
};
[[nodiscard]] const char* to_string(Rejection rejection);
/// Returns true for an observation that was left out because of its residual.
[[nodiscard]] constexpr bool is_outlier(Rejection r) {
  return r == Rejection::kLate || r == Rejection::kEarly;
}
/// Returns true if the residual of an observation decides about its use.
[[nodiscard]] constexpr bool is_by_residual(Rejection r) { return r == Rejection::kUsed || is_outlier(r); }

/// Covariance of a pose's tangent vector: (x, y, heading) in the plane, 3x3; translation and rotation in the
/// vehicle frame in space, 6x6. It has a fixed capacity, so that a fix does not allocate.
using PoseCovariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

/// Variance of an unknown angle, uniform over a full turn [rad^2]. A rotation whose variance reaches it was
/// not estimated.
inline constexpr double kUnknownRotationVariance = std::numbers::pi * std::numbers::pi / 3;

/// Velocity in the vehicle's frame: along x, y, z [m/s] and about x, y, z [rad/s].
using Velocity = Eigen::Matrix<double, 6, 1>;
struct VelocityEstimate {
  Velocity mean = Velocity::Zero();
  Velocity variance = Velocity::Zero();  ///< of each component; zero out of the plane for planar motion
};

/// Pose of the vehicle from the arrivals of one epoch or one instant of a drive, or the reason why there is
/// none.
struct Fix {
  FixStatus status = FixStatus::kTooFewArrivals;
  double time_s = 0.0;
  VehicleId vehicle;
  std::int64_t epoch = kNoEpoch;
  Pose T_map_vehicle;  ///< valid if status is kOk
  PoseCovariance covariance;
  std::optional<VelocityEstimate> velocity{};  ///< for fixes of a moving trajectory
  double protection_level_m =
      0.0;  ///< horizontal; see localizers/common/separation.h. 0: not computed, or not available
  int arrivals_used = 0;
  int arrivals_rejected = 0;
  double cost = 0.0;                  ///< half the weighted sum of squared residuals of the arrivals used
  std::vector<Rejection> rejections;  ///< one entry for each arrival; empty if there is no fix

  [[nodiscard]] bool ok() const { return status == FixStatus::kOk; }
};

/// Covariance of a pose in the convention of ROS: position in the map, small rotations about the map's axes.
/// The covariance of a Fix uses rotations about the axes of the vehicle. For a planar pose, the components
/// out of the plane are zero.
[[nodiscard]] Eigen::Matrix<double, 6, 6> covariance_in_map(const PoseCovariance& covariance, const Pose& T);

/// Integrity of a fix.
enum class Integrity : std::uint8_t {
  kOk,        ///< the error is bounded by the protection level, at the risk defined in separation.h
  kDegraded,  ///< the error is not bounded, or a faulty beacon had to be excluded
  kNoFix
};
[[nodiscard]] Integrity integrity(const Fix& fix);
[[nodiscard]] const char* to_string(Integrity integrity);
/// Reason for the integrity: "beacon_fault" or "not_protected" for a degraded fix, the status if there is no
/// fix, empty for kOk.
[[nodiscard]] const char* integrity_reason(const Fix& fix);

}  // namespace octant
