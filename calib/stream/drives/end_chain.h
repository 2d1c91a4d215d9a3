// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calib/chain/chain_reduction.h"
#include "calib/sums/log_buffer.h"
#include "calib/sums/reduced_system.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {

/// @param chain  its matrices have the size that they had when they were written
template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<OpenChain> auto&& chain) {
  buffer.exchange(chain.has_left, chain.has_right, chain.cost, chain.gradient, chain.H);
}

/// Eliminates the states between the pieces of a drive in order. With D the block of an end, U its coupling
/// to the next one, G that to the parameters and the gradient, D = L L',
///   W = L^-1 U,   Y = L^-1 G,   D_next -= W'W,   G_next -= W'Y,   H -= Y'Y.
/// Their steps e for a step dx of the parameters follow backwards: L' e = -(Y (dx, 1) + W e_next).
class EndChain {
 public:
  /// @param block  unknowns of a state (Trajectory::block_size())
  EndChain(Eigen::Index parameters, Eigen::Index block)
      : block_(block),
        sum_(Eigen::MatrixXd::Zero(parameters + 1, parameters + 1)),
        D_(NodeBlock::Zero(block, block)) {}

  /// The pieces, first to last.
  void append(const OpenChain& piece);
  /// Adds their reduced system to another one; the cost includes the gain of the ends' own step.
  void add_to(ReducedSystem& system) const;
  /// The step of each end, in its unknowns, when the parameters step so.
  [[nodiscard]] std::vector<NodeVector> steps(const Eigen::VectorXd& dx) const;

 private:
  using Border = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxBlock>;
  struct EliminatedEnd {
    NodeBlock L, W;
    Border Y;
  };
  Eigen::Index block_;
  double cost_ = 0.0;
  Eigen::MatrixXd sum_;  ///< system of the parameters and the gradient
  NodeBlock D_;
  Border G_;  ///< border of the end after the last piece
  std::vector<EliminatedEnd> ends_;
};

}  // namespace octant::calib
