// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/chain/chain_paths.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

struct ReducedSystem;

/// Reduced system of a part of a chain whose ends are shared with its neighbours.
struct OpenChain {
  bool has_left = false, has_right = false;  ///< ends that are not eliminated
  double cost = 0.0;                         ///< minus the gain of a step of the inner states
  Eigen::VectorXd gradient;                  ///< by parameters, left end, right end
  Eigen::MatrixXd H;                         ///< both triangles
};

/// Eliminates the states of segments of a trajectory, which gives the gradient and Gauss-Newton matrix of
/// their cost in the shared parameters:
///   H = sum Js'Js - Js'Jx (Jx'Jx)^-1 Jx'Js,   g = Js'r - Js'Jx (Jx'Jx)^-1 Jx'r
/// Jx'Jx is block-tridiagonal. A long chain is divided (nested dissection: George 1973): the inner states of
/// each part are eliminated onto its two ends and its parameters, all parts in parallel; then the ends, one
/// after the other. This is exact, and the sums do not depend on the number of threads.
class ChainReduction {
 public:
  /// @param trajectory, layout  not owned
  /// @param segments  those that it will be asked for
  ChainReduction(const Trajectory& trajectory, const ParameterLayout& layout,
                 const std::vector<std::size_t>& segments)
      : paths_(trajectory, layout, segments) {}

  /// Paths that some arrival of the segments took.
  [[nodiscard]] const std::vector<PathColumns>& paths() const { return paths_.paths(); }

  /// Adds gradient and lower triangle of H at the present states of the trajectory.
  /// @param place  position of each column of the layout in the system, ascending; -1: not in it
  /// @return 1/2 sum of rho, minus the remaining gain of a step of the states:
  ///   r'r / 2 - r'Jx (Jx'Jx)^-1 Jx'r / 2
  double reduce(const Segment& segment, const SharedState& state, const RobustLoss& loss,
                const std::vector<int>& place, int threads, ReducedSystem& system) const;

  /// Eliminates all states of a segment at the present states of the trajectory, except the ends that the
  /// result keeps.
  /// @param columns  number of columns of the system of parameters
  void reduce_open(const Segment& segment, const SharedState& state, const RobustLoss& loss,
                   const std::vector<int>& place, std::size_t columns, OpenChain& out) const;

 private:
  ChainPaths paths_;
};

}  // namespace octant::calib
