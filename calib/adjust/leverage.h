// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calib/adjust/covariance.h"
#include "calib/problem/parameters.h"
#include "calib/problem/shared_entries.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Rows that the observations of segments [first, last) give at most (see for_each_row).
[[nodiscard]] inline std::size_t most_rows(const Trajectory& t, std::size_t first, std::size_t last) {
  std::size_t rows = 0;
  for (std::size_t i = first; i < last; ++i) {
    const Segment& s = t.segments[i];
    rows += 2 * (s.last_arrival - s.first_arrival) + s.last_bearing - s.first_bearing +
            6 * (s.last_pose - s.first_pose + s.last_odometry - s.first_odometry + s.last_motion -
                 s.first_motion);
  }
  return rows;
}

/// One observation of a solved adjustment and its pull on the result.
struct RowLeverage {
  const Trajectory& trajectory;
  const ObservationRow& row;  ///< whitened
  double leverage = 0.0;      ///< h = d(adjusted) / d(observed), 0..1; the redundancy number is 1 - h
  double shift_m =
      0.0;  ///< time-of-flight rows: largest shift of a free beacon coordinate by an error of one sigma
  const Eigen::RowVectorXd& f;  ///< influence: d theta = -L f' per sigma of error
};

/// A lateness that all arrivals of one beacon share, as one more unknown c of the adjustment (not estimated).
struct LatenessInformation {
  double total = 0.0;          ///< c'c: if all else were known [1/s^2]
  double remaining = 0.0;      ///< c'(I - H)c: information in the residuals [1/s^2]
  double shift_m_per_s = 0.0;  ///< largest shift of a free beacon coordinate by it
};

/// Diagonal of the hat matrix of the whole bundle adjustment, segment by segment, in time linear in the
/// observations.
///
/// The joint covariance of the shared parameters is C = L L'; in coordinates theta = L xi their information
/// is the unit matrix. With Jx, Js the rows' derivatives by states and by shared parameters, A = Jx'Jx of a
/// segment (block-tridiagonal) and X = -A^-1 Jx'Js L the response of the states to xi,
///   h = Jx A^-1 Jx' + |f|^2,   f = Js L + Jx X,   d theta = L f' per sigma of error.
/// Only the diagonal and first off-diagonal blocks of A^-1 are needed: the smoother's recursions of
/// models/localizers/chain/chain_windows.h; X_k by back-substitution. Chains are processed in blocks, so that
/// memory does not grow with (nodes x parameters). Unobservable directions of states (heading of a single
/// antenna) are fixed and are not counted as unknowns.
///
/// If the covariance is not formed as a whole, L belongs to the parameters of a segment: leverages are the
/// same; shifts are those of the beacons received there, and the lateness is not computed.
class LeverageSweep {
 public:
  /// @param C  joint covariance of the layout's parameters, not owned
  LeverageSweep(const ParameterLayout& layout, const Covariance& C);

  /// Calls visit(RowLeverage) for every used row of the placed segments, with plain squares, at solved
  /// states.
  /// @param every  for long logs: only the first of this number of the segments [first, last)
  template <class Visitor>
  void sweep(const Trajectory& trajectory, const SharedState& state, std::size_t first, std::size_t last,
             std::size_t stride, Visitor&& visit) {
    for (std::size_t s = first; s < last; s += stride) {
      const Segment& segment = trajectory.segments[s];
      if (!trajectory.nodes[segment.first_node].placed) continue;
      if (C_->matrix() == nullptr) focus(trajectory, segment, state);
      forward(trajectory, segment, state);
      for (std::size_t block = block_count(); block-- > 0;) {
        backward(trajectory, segment, state, block);
        for_each_row(trajectory, part(trajectory, segment, block), state,
                     [&](const ObservationRow& row) { visit(leverage_of(trajectory, segment, row)); });
      }
    }
  }

  /// Leverage of a row that touches shared parameters only (a prior, a taped distance).
  [[nodiscard]] double leverage_of(const std::vector<std::pair<int, double>>& entries) const;
  /// Information on each beacon's lateness, after all trajectories were processed; empty if the covariance is
  /// not dense.
  [[nodiscard]] std::vector<LatenessInformation> lateness() const;
  /// L of the whole covariance (of the current segment, if that is not formed).
  [[nodiscard]] const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& root() const {
    return root_;
  }

 private:
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  [[nodiscard]] std::size_t block_count() const { return carry_.size(); }
  [[nodiscard]] Segment part(const Trajectory& t, const Segment& segment, std::size_t block) const;
  void focus(const Trajectory& t, const Segment& segment, const SharedState& state);
  void set_root(const Eigen::MatrixXd& L, const std::vector<int>& coordinates);
  void forward(const Trajectory& t, const Segment& segment, const SharedState& state);
  void backward(const Trajectory& t, const Segment& segment, const SharedState& state, std::size_t block);
  void assemble(const Trajectory& t, const Segment& segment, const SharedState& state, std::size_t block,
                bool first_pass);
  void eliminate(bool first_pass);
  void project(const ObservationRow& row, std::size_t run);
  RowLeverage leverage_of(const Trajectory& t, const Segment& segment, const ObservationRow& row);
  const Eigen::MatrixXd& beacon_shift(std::size_t node);

  const ParameterLayout& layout_;
  const SharedState* state_ = nullptr;  ///< state of the present sweep
  const Covariance* C_;
  std::vector<int> place_;    ///< position of each parameter in L; -1: not in the present segment
  std::vector<int> touched_;  ///< parameters in L
  RowMatrix root_;            ///< L, parameters x rank
  Eigen::MatrixXd beacon_C_;  ///< beacon coordinates x parameters
  RowMatrix beacon_root_;     ///< rows of L of the beacon coordinates
  std::vector<double> lateness_total_, lateness_remaining_;
  RowMatrix lateness_shared_;  ///< beacons x rank

  // For the present segment, by node.
  std::size_t count_ = 0;
  int n_ = 0;
  std::vector<NodeBlock> D_, U_, inverse_;
  std::vector<RowMatrix> carry_;  ///< contribution of the nodes before a block to its coupling
  // For the present block, from its first node to one node beyond its end.
  std::size_t first_ = 0, last_ = 0;
  RowMatrix G_, lateness_G_, X_;
  std::vector<NodeBlock> P_, cross_;
  Eigen::RowVectorXd f_;
  struct StateShift {
    std::size_t node = 0;
    bool known = false;
    Eigen::MatrixXd by_state;  ///< beacon coordinates x state
  };
  std::array<StateShift, 2> shifts_;
  RowEntries entries_;  ///< result of the row projected last
};

}  // namespace octant::calib
