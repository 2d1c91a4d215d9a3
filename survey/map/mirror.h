// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "survey/map/paths.h"

namespace octant::survey {

/// If the received beacons are (nearly) collinear, the mirror image of the position explains the ranges
/// (nearly) as well.
struct MirrorImage {
  bool ambiguous = false;  ///< not distinguishable from the true position with 99.9 % confidence
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();  ///< the image, adjusted to the ranges
};

/// Mirror image of a pose, for planar motion (spatial poses are never ambiguous): the reflection in the line
/// that fits the received beacons best, adjusted to the ranges of the true pose. The chi-squares of the two
/// fixes differ by q, that of the image, with a sigma of 2 sqrt(q). Localizers require a difference of 4
/// (models/localizers/least_squares/epoch_fix.h), so the two are distinguishable at 0.1 % if q - 3.09 * 2
/// sqrt(q) > 4, which is q > 45.8. At most poses the ranges of the image are off by hundreds of sigmas before
/// the adjustment, and no adjustment makes it fit. This quick test processes one pose after another and keeps
/// data about the beacons of the last pose.
class MirrorFilter {
 public:
  /// @param heard  beacons received at the pose, by index
  [[nodiscard]] bool may_have_image(const SurveyModel& model, const PoseAt& pose,
                                    const std::vector<std::size_t>& heard);

 private:
  std::vector<std::size_t> last_;
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero(), along_ = Eigen::Vector2d::UnitX();
};

[[nodiscard]] MirrorImage mirror_image(const SurveyModel& model, const PoseAt& pose,
                                       const std::vector<HeardPath>& paths);

}  // namespace octant::survey
