// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calib/adjust/tile.h"
#include "calib/chain/chain_reduction.h"

namespace octant::calib {

/// The states at which a planar drive is cut into pieces, eliminated one after the other. With D the block of
/// an end, U its coupling to the next one, G that to the parameters and the gradient, D = L L',
///   W = L^-1 U,   Y = L^-1 G,   D_next -= W'W,   G_next -= W'Y,   H -= Y'Y
/// what they step when the parameters step by dx follows backwards, L' e = -(Y (dx, 1) + W e_next).
class EndChain {
 public:
  explicit EndChain(Eigen::Index parameters) : sum_(Eigen::MatrixXd::Zero(parameters + 1, parameters + 1)) {}

  /// The pieces, first to last.
  void append(const OpenChain& piece);
  /// Adds what is left of them all to a system; its cost is less what the ends' own step gains.
  void add_to(ReducedSystem& system) const;
  /// Of each end (x, y, heading), when the parameters step so.
  [[nodiscard]] std::vector<Eigen::Vector3d> steps(const Eigen::VectorXd& dx) const;

 private:
  using Border = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  struct End {
    Eigen::Matrix3d L, W;
    Border Y;
  };
  double cost_ = 0.0;
  Eigen::MatrixXd sum_;  ///< of the parameters and the gradient
  Eigen::Matrix3d D_ = Eigen::Matrix3d::Zero();
  Border G_;  ///< of the end behind the last piece
  std::vector<End> ends_;
};

}  // namespace octant::calib
