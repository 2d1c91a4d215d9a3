// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/fix.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/drive/chain_covariance.h"

namespace octant {

/// A place on a drive: between node and node + 1 of a trajectory.
struct DriveInstant {
  std::size_t node = 0;
  double alpha = 0.0;
};

/// The pose's part, of so many degrees of freedom, that the states of a segment's nodes amount to at an
/// instant.
[[nodiscard]] NodeVector at_instant(std::span<const NodeVector> x, const Segment& segment,
                                    const DriveInstant& instant, int dof);

/// Adds to each covariance of a pose what does not average out along a drive: with H the information
/// of all states, G their coupling to the calibrated parameters of joint covariance C, and g_p the coupling
/// to a bias that a beacon-receiver pair keeps,
///   P = H^-1 + H^-1 G C G' H^-1 + pair_sigma_s^2 sum_p H^-1 g_p g_p' H^-1
/// One solution of the chain for each column of a root of C and for each pair.
void add_drive_calibration(const Trajectory& trajectory, const Segment& segment, const SharedState& state,
                           const ChainFactor& chain, const CalibrationPart& calibration, double pair_sigma_s,
                           std::span<const DriveInstant> instants, std::vector<PoseCovariance>& covariances);

/// The same for one node, with which a filter begins: what its pose follows an error of each parameter (a
/// row for each degree of freedom), dx = by * dtheta.
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
