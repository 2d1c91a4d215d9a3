// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace octant::survey {

/// Poses at which a geometry is evaluated; all lists have the same length.
struct PoseList {
  std::vector<double> x_m, y_m, z_m, heading_rad;  ///< z of the vehicle's frame
  [[nodiscard]] std::size_t size() const { return x_m.size(); }
  void add(double x, double y, double z, double heading) {
    x_m.push_back(x), y_m.push_back(y), z_m.push_back(z), heading_rad.push_back(heading);
  }
};

inline constexpr double kNoFix =
    std::numeric_limits<double>::infinity();  ///< in place of a dilution (beyond 10,000 too) or a sigma

/// Quantities at each pose. Dilutions are sigmas of the pose for a range sigma of 1 m of all ranges, one row
/// for each arrival; with an array of receivers, several arrivals come from one beacon. kNoFix if the
/// received beacons do not determine the pose.
enum Figure : std::size_t {
  kHdop,
  kVdop,  ///< spatial motion; else 0
  kPdop,
  kTdop,  ///< with a clock offset; else 0
  kGdop,
  kHeadingDop,  ///< [rad/m]; 0 where the heading is no unknown
  /// Expected standard deviation from the arrivals' own noise: horizontal (root of both variances' sum), by
  /// axis [m], of the heading [rad].
  kSigma,
  kSigmaX,
  kSigmaY,
  kSigmaZ,
  kSigmaHeading,
  kShiftBySpeed,  ///< horizontal shift of the fix by a relative error of the speed of 1 [m]: times sigma_c /
                  ///< c it is the speed's part
  kCovarianceXy,  ///< covariance of x and y, for kSigmaX and kSigmaY [m2]
  /// Integrity, for planning (of a fix: models/localizers/common/separation.h): largest bias of one beacon's
  /// ranges that stays unnoticed (0.1 %, power 80 %), by how much such a bias moves the fix at worst, and the
  /// horizontal protection level with the arrivals' noise [m]; kNoFix where a beacon's fault could not be
  /// noticed.
  kDetectableBias,
  kFaultShift,
  kProtection,
  kBeacons,   ///< number received
  kArrivals,  ///< number received
  kFigures
};
/// Values of each Figure, pose by pose; empty if it was not requested.
using GeometryFigures = std::array<std::vector<double>, kFigures>;

}  // namespace octant::survey
