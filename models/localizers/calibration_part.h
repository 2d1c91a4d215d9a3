// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/trajectory.h"

namespace octant {

/// The part of a fix's uncertainty that comes from the calibration and does not average out: with C the joint covariance of the
/// calibrated parameters, D the information of the state and G its coupling to them,
///   P = D^-1 + D^-1 G C G' D^-1
class CalibrationPart {
 public:
  explicit CalibrationPart(const Deployment& deployment);

  /// Adds the second term to the covariance of a fix whose state the segment holds; no change where nothing is stated.
  void add_to(PoseCovariance& covariance, const Trajectory& trajectory, const Segment& segment, const SharedState& state) const;

 private:
  Eigen::MatrixXd covariance_;
  std::vector<std::array<int, 4>> beacon_, receiver_;  ///< columns of x, y, z, delay in the joint covariance; -1: not in it
  int site_delay_ = -1, speed_ = -1;
  std::array<int, kAttenuationUnknowns> attenuation_ = {-1, -1, -1, -1};
};

}  // namespace octant
