// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/localizers/chain/chain_factor.h"
#include "models/localizers/chain/chain_windows.h"
#include "models/localizers/common/calibration_part.h"

namespace octant {

/// What the calibration leaves in the rows of a drive and does not average out along it: with H the
/// information of all states, G their coupling to the calibrated parameters of joint covariance C = R R',
/// and g_p the coupling to a bias that a beacon-receiver pair keeps,
///   P = H^-1 + H^-1 G C G' H^-1 + pair_sigma_s^2 sum_p H^-1 g_p g_p' H^-1
/// One error of the rows, and so one solution of the chain, for each column of R and for each pair.
class CalibrationErrors {
 public:
  /// @param calibration  outlives this
  CalibrationErrors(const Trajectory& trajectory, const Segment& segment, std::size_t receivers,
                    const CalibrationPart& calibration, double pair_sigma_s);

  [[nodiscard]] Eigen::Index columns() const { return root_.cols() + pairs_; }
  /// Of a row; false: it depends on nothing calibrated.
  [[nodiscard]] bool of(const ObservationRow& row, Eigen::RowVectorXd& errors) const;

 private:
  [[nodiscard]] std::size_t pair_of(BeaconId beacon, ReceiverId receiver) const {
    return beacon.index() * receivers_ + receiver.index();
  }
  const CalibrationPart& calibration_;
  std::size_t receivers_;
  double pair_sigma_s_;
  std::vector<int> place_;       ///< of a parameter among those that the drive depends on; -1: it does not
  ChainWindow::Matrix root_;     ///< R of these
  std::vector<int> pair_place_;  ///< of beacon * receivers + receiver among those heard
  Eigen::Index pairs_ = 0;
};

/// The same for one node, with which a filter begins: how its pose follows an error of each parameter (a row
/// for each degree of freedom), dx = by * dtheta.
struct NodeCalibration {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6>;
  Matrix by_parameter;  ///< a column for each column of C
  Matrix by_pair;       ///< a column for each beacon and receiver: beacon * receivers + receiver
};
/// Fills `out`, whose columns are there already.
void node_calibration(const Trajectory& trajectory, const Segment& segment, const SharedState& state,
                      const ChainFactor& chain, const CalibrationPart& calibration, std::size_t node,
                      NodeCalibration& out);

}  // namespace octant
