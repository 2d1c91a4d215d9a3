// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "survey/geometry/survey_model.h"

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

/// Information of a beacon on the unknowns at each pose, weighted by the noise of the ranges: the packed
/// upper triangle, entry by entry (entry e of pose i at e * poses + i). Layers of several beacons add up.
struct BeaconLayer {
  std::vector<double> information;
  std::vector<std::uint8_t> heard;  ///< 1: received by at least one receiver
};

struct MapOptions {
  int threads = 1;
  bool integrity = true;  ///< detectable biases and protection levels
};

/// Dilutions, sigmas and integrity at each pose, in vector lanes and threads.
[[nodiscard]] GeometryFigures evaluate_poses(const SurveyModel& model, const PoseList& poses,
                                             const MapOptions& options = {});

/// Audibility: one row of poses for each beacon, 1 if at least one receiver receives it.
[[nodiscard]] std::vector<std::vector<std::uint8_t>> heard_at(const SurveyModel& model, const PoseList& poses,
                                                              int threads = 1);

/// Information layers, for searches over many sets of beacons at the same poses: a layer for each candidate
/// once, then sums.
/// @param beacon  any beacon, of the model or not; walls, receivers, hearing and noise are those of the model
[[nodiscard]] BeaconLayer beacon_layer(const SurveyModel& model, const SurveyBeacon& beacon,
                                       const PoseList& poses, int threads = 1);

/// Expected horizontal standard deviation at each pose [m] for the sum of the layers' information (stored as
/// BeaconLayer::information); kNoFix where no fix is possible. Allocates no memory.
void sigma_of_information(const Unknowns& unknowns, std::span<const double> information,
                          std::span<double> sigma_m);

}  // namespace octant::survey
