// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

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
struct GeometryFigures {
  std::vector<double> hdop, vdop, pdop, tdop,
      gdop;                                   ///< vdop: spatial motion; tdop: with a clock offset; else 0
  std::vector<double> heading_dop_rad_per_m;  ///< 0 where the heading is no unknown
  /// Expected standard deviation from the arrivals' own noise: horizontal (root of both variances' sum), by
  /// axis, of the heading.
  std::vector<double> sigma_m, sigma_x_m, sigma_y_m, sigma_z_m, sigma_heading_rad;
  /// Horizontal shift of the fix by a relative error of the speed of 1: times sigma_c / c it is the speed's
  /// part.
  std::vector<double> shift_by_speed_m;
  std::vector<double> covariance_xy_m2;  ///< beside sigma_x_m and sigma_y_m
  /// Integrity, for planning (of a fix: models/localizers/common/separation.h): largest bias of one beacon's
  /// ranges that stays unnoticed (0.1 %, power 80 %), by how much such a bias moves the fix at worst, and the
  /// horizontal protection level with the arrivals' noise; kNoFix where a beacon's fault could not be
  /// noticed.
  std::vector<double> detectable_bias_m, fault_shift_m, protection_m;
  std::vector<std::uint16_t> beacons, arrivals;  ///< heard
};

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
