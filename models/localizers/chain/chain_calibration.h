// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/localizers/chain/chain_factor.h"
#include "models/localizers/chain/chain_windows.h"
#include "models/localizers/common/calibration_part.h"

namespace octant {

/// Effect of calibration errors on the states of a drive, which does not average out along it. With the
/// information H of all states, their coupling G to the calibrated parameters with joint covariance C = R R',
/// and the coupling g_p to the constant bias of a beacon-receiver pair,
///   P = H^-1 + H^-1 G C G' H^-1 + pair_sigma_s^2 sum_p H^-1 g_p g_p' H^-1
/// Each column of R and each pair gives one error of the rows, and so one solution of the chain.
class CalibrationErrors {
 public:
  /// @param calibration  must outlive this object
  CalibrationErrors(const Trajectory& trajectory, const Segment& segment, std::size_t receivers,
                    const CalibrationPart& calibration, double pair_sigma_s);

  [[nodiscard]] Eigen::Index columns() const { return root_.cols() + pairs_; }
  /// Errors of a row; false if the row does not depend on calibrated parameters.
  [[nodiscard]] bool of(const ObservationRow& row, Eigen::RowVectorXd& errors) const;

 private:
  [[nodiscard]] std::size_t pair_of(BeaconId beacon, ReceiverId receiver) const {
    return beacon.index() * receivers_ + receiver.index();
  }
  const CalibrationPart& calibration_;
  std::size_t receivers_;
  double pair_sigma_s_;
  std::vector<int> place_;    ///< index of a parameter among those that the drive depends on; -1: it does not
  ChainWindow::Matrix root_;  ///< rows of R for these parameters
  std::vector<int> pair_place_;  ///< index of each pair, beacon * receivers + receiver, among those received
  Eigen::Index pairs_ = 0;
};

/// Sensitivity of a node's pose to calibration errors, from which a filter starts: dx = by * dtheta, with a
/// row for each degree of freedom.
struct NodeCalibration {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6>;
  Matrix by_parameter;  ///< one column for each column of C
  Matrix by_pair;       ///< one column for each pair: beacon * receivers + receiver
};
/// Fills `out`, whose columns must already exist.
void node_calibration(const Trajectory& trajectory, const Segment& segment, const SharedState& state,
                      const ChainFactor& chain, const CalibrationPart& calibration, std::size_t node,
                      NodeCalibration& out);

}  // namespace octant
