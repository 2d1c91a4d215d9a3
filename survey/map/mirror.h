// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "survey/map/paths.h"

namespace octant::survey {

/// Where the heard beacons stand (nearly) in a line, the place on its other side explains the ranges (nearly)
/// as well.
struct MirrorImage {
  bool ambiguous = false;  ///< cannot be told from the true place with 99.9 % certainty
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();  ///< the image, adjusted to the ranges
};

/// Planar motion only (else never ambiguous): the reflection in the line that fits the heard beacons best,
/// adjusted to the ranges of the true pose. The fixes' chi-squares differ by q, the image's own, give or take
/// 2 sqrt(q): with localizers asking for a difference of 4 (models/localizers/least_squares/epoch_fix.h), the
/// two are told apart at 0.1 % where q - 3.09 * 2 sqrt(q) > 4, q > 45.8.
///
/// With the ranges of the image before any adjustment off by hundreds of sigmas, as in most places, no
/// adjustment makes it fit. This quick look is for one pose after another: what it knows of the last one's
/// beacons it keeps.
class MirrorFilter {
 public:
  /// @param heard  beacons heard at the pose, by index
  [[nodiscard]] bool may_have_image(const SurveyModel& model, const PoseAt& pose,
                                    const std::vector<std::size_t>& heard);

 private:
  std::vector<std::size_t> last_;
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero(), along_ = Eigen::Vector2d::UnitX();
};

[[nodiscard]] MirrorImage mirror_image(const SurveyModel& model, const PoseAt& pose,
                                       const std::vector<HeardPath>& paths);

}  // namespace octant::survey
