// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <numbers>
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

/// Why an arrival was left out of a fix or of a calibration.
enum class Rejection : std::uint8_t {
  kUsed = 0,
  kLate,            ///< later than the pose explains: echo
  kEarly,           ///< earlier than the pose explains: spurious
  kBeaconUnusable,  ///< its beacon is undetermined
  kNoPose,          ///< no vehicle state at its time
  kTriangle,        ///< farther than the triangle inequality with another beacon allows (Kleeman eq. 5-6)
  kOutOfRange,      ///< nearer or farther than is possible at the site (Chang's first rule)
  kReflection,      ///< a second arrival from the same beacon right behind the first (Chang's second rule)
  kOutvoted,    ///< the fixes it takes part in disagree with the others (Kleeman's longsolve, Thamma's four
                ///< times)
  kNotNeeded,   ///< the method fixes the pose from others
  kUnknownId,   ///< its beacon or receiver is none of the deployment's
  kBeaconFault  ///< its beacon's arrivals together contradict those of all others
};
[[nodiscard]] const char* to_string(Rejection rejection);
/// Whether an observation was left out because of its residual.
[[nodiscard]] constexpr bool is_outlier(Rejection r) {
  return r == Rejection::kLate || r == Rejection::kEarly;
}
/// Whether it is the residual that decides about an observation.
[[nodiscard]] constexpr bool is_by_residual(Rejection r) { return r == Rejection::kUsed || is_outlier(r); }

/// Covariance of a pose's tangent vector: planar (x, y, heading), 3x3; spatial (translation, rotation in the
/// vehicle frame), 6x6. Its room is fixed, so that a fix takes no memory of its own.
using PoseCovariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

/// Variance of an angle of which nothing is known, uniform over a turn [rad^2]: rotations in a covariance
/// that reach it were not estimated.
inline constexpr double kUnknownRotationVariance = std::numbers::pi * std::numbers::pi / 3;

/// Where the vehicle is, from the arrivals of one epoch or at one instant of a drive; or the reason why that
/// is not known.
struct Fix {
  FixStatus status = FixStatus::kTooFewArrivals;
  double time_s = 0.0;
  VehicleId vehicle;
  std::int64_t epoch = kNoEpoch;
  Pose T_map_vehicle;  ///< meaningful when status is kOk
  PoseCovariance covariance;
  double protection_level_m =
      0.0;  ///< horizontal, see localizers/common/separation.h; 0: not computed, or not protected
  int arrivals_used = 0;
  int arrivals_rejected = 0;
  double cost = 0.0;                  ///< half the weighted sum of squares of the arrivals used
  std::vector<Rejection> rejections;  ///< one for each arrival given; empty if there is no fix

  [[nodiscard]] bool ok() const { return status == FixStatus::kOk; }
};

/// What a fix may be used for.
enum class Integrity : std::uint8_t {
  kOk,        ///< its error is bounded by its protection level, at the risk that separation.h states
  kDegraded,  ///< a fix whose error nothing bounds, or from which a beacon at fault had to be left out
  kNoFix
};
[[nodiscard]] Integrity integrity(const Fix& fix);
[[nodiscard]] const char* to_string(Integrity integrity);
/// Why: of a degraded fix "beacon_fault" or "not_protected", of none its status; empty where all is well.
[[nodiscard]] const char* integrity_reason(const Fix& fix);

}  // namespace octant
