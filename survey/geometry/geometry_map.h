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

/// Poses at which a geometry is looked at; all lists are of one length.
struct PoseList {
  std::vector<double> x_m, y_m, z_m, heading_rad;  ///< z of the vehicle's frame
  [[nodiscard]] std::size_t size() const { return x_m.size(); }
  void add(double x, double y, double z, double heading) {
    x_m.push_back(x), y_m.push_back(y), z_m.push_back(z), heading_rad.push_back(heading);
  }
};

inline constexpr double kNoFix =
    std::numeric_limits<double>::infinity();  ///< in place of a dilution (beyond 10,000 too) or a sigma

/// What a geometry gives at each pose. Dilutions are sigmas of the pose by a range sigma of 1 m, all ranges
/// alike, an arrival a row; with receivers' arrays several arrivals come from one beacon. kNoFix where what
/// is heard does not determine the pose.
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
  kCovarianceXy,  ///< beside kSigmaX and kSigmaY [m2]
  /// Integrity, for planning (of a fix: models/localizers/common/separation.h): largest bias of one beacon's
  /// ranges that stays unnoticed (0.1 %, power 80 %), by how much such a bias moves the fix at worst, and the
  /// horizontal protection level with the arrivals' noise [m]; kNoFix where a beacon's fault could not be
  /// noticed.
  kDetectableBias,
  kFaultShift,
  kProtection,
  kBeacons,   ///< heard
  kArrivals,  ///< heard
  kFigures
};
/// Of each Figure its values, pose by pose; empty where it was not asked for.
using GeometryFigures = std::array<std::vector<double>, kFigures>;

/// What a beacon tells at each pose: the packed upper triangle of its information on the unknowns, entry by
/// entry (entry e of pose i at e * poses + i), weighted by the ranges' noise. Layers of several beacons add
/// up.
struct BeaconLayer {
  std::vector<double> information;
  std::vector<std::uint8_t> heard;  ///< 1: heard by at least one receiver
};

struct MapOptions {
  int threads = 1;
  bool integrity = true;  ///< detectable biases and protection levels
};

/// Dilutions, sigmas and integrity at each pose, in vector lanes and threads.
[[nodiscard]] GeometryFigures evaluate_poses(const SurveyModel& model, const PoseList& poses,
                                             const MapOptions& options = {});

/// Who is heard where: one row of poses for each beacon, 1 where at least one receiver hears it.
[[nodiscard]] std::vector<std::vector<std::uint8_t>> heard_at(const SurveyModel& model, const PoseList& poses,
                                                              int threads = 1);

/// The cheap way for whoever tries many sets of beacons over the same poses: a layer for each candidate once,
/// then sums.
/// @param beacon  any beacon, of the model or not; walls, receivers, hearing and noise are the model's
[[nodiscard]] BeaconLayer beacon_layer(const SurveyModel& model, const SurveyBeacon& beacon,
                                       const PoseList& poses, int threads = 1);

/// Expected horizontal standard deviation at each pose [m], of the sum of the layers' information (laid out
/// as BeaconLayer::information); kNoFix where there is no fix. Nothing is allocated.
void sigma_of_information(const Unknowns& unknowns, std::span<const double> information,
                          std::span<double> sigma_m);

}  // namespace octant::survey
