// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "survey/map/paths.h"

namespace octant::survey {

/// Horizontal covariance that a fix has from the calibration: systematic, it does not average out over fixes.
struct SystematicPart {
  double xx_m2 = 0.0, xy_m2 = 0.0, yy_m2 = 0.0;
};

/// Contribution of the calibration's uncertainty to the covariance of a fix. With D the information of the
/// pose, G its coupling to the calibrated parameters and C their joint covariance
/// (models/localizers/common/calibration_part.h):
///
///   D^-1 G C G' D^-1
///
/// Beacons, receivers, delays, speed and attenuation are as in the deployment's covariance. A deployment
/// without one has the covariance of each beacon, the sigma of its delay and that of the speed, as if
/// independent.
class CalibrationMap {
 public:
  /// @param model  of the same deployment: its beacons are found by name
  CalibrationMap(const Deployment& deployment, const SurveyModel& model);

  /// All parameters are exact.
  [[nodiscard]] bool exact() const { return root_.cols() == 0; }

  /// Covariances of many poses: paths[i] are the received paths at pose i. Poses without a fix get zeros.
  void systematic(const SurveyModel& model, std::span<const std::vector<HeardPath>> paths,
                  std::span<SystematicPart> parts) const;

 private:
  void couple(const SurveyModel& model, const std::vector<HeardPath>& paths, double* x_row, double* y_row,
              Eigen::Index stride) const;

  Eigen::MatrixXd root_;                               ///< C = root root'
  std::vector<std::array<int, 4>> beacon_, receiver_;  ///< columns of x, y, z, delay; -1: not a parameter
  int site_delay_ = -1, speed_ = -1;
  std::array<int, kAttenuationUnknowns> attenuation_ = {-1, -1, -1, -1};
  std::optional<AttenuationModel> walk_;
  double mps_by_delay_ = 343.0, speed_mps_ = 343.0;
};

}  // namespace octant::survey
