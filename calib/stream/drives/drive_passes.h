// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "calib/stream/drives/drive_index.h"
#include "calib/stream/drives/end_chain.h"
#include "calib/stream/kept_states.h"
#include "calib/stream/log_readings.h"

namespace octant::calib {

/// The drives of a log, read again in each pass, in pieces on several threads. Neighbouring pieces share the
/// state between them. Each pass fixes these states, solves the others and eliminates them onto the two ends
/// of each piece and the parameters. Then the ends are eliminated in order, which is a Gauss-Newton step of
/// states and parameters together. Between passes, memory contains each state (24 bytes in the plane) and the
/// mark of each arrival (one byte). Ranks store and read only their own pieces and exchange the ends.
class DrivePasses : public LogReadings {
 public:
  DrivePasses(const ReadingTask& task, const DriveIndex& index);

  [[nodiscard]] Result<Placed> place(const Estimate& estimate, double suspect_sigmas, bool reject) override;
  [[nodiscard]] Result<PassSum> pass(const Estimate& estimate, RejectionPolicy policy) override;
  void accept() override { from_ = tried_; }
  /// The sample consists of evenly spaced segments, each solved separately (as error_sample does):
  /// information from its neighbours about its ends is not part of the sample.
  [[nodiscard]] Result<void> gather(const Estimate& estimate, FindingsGatherer& gatherer) override;

 private:
  /// States at the ends of pieces and their linearisation.
  struct PieceEnds {
    std::vector<Node> state;       ///< state behind each piece
    Eigen::VectorXd x;             ///< parameters of the linearisation; empty: there is none
    std::vector<EndChain> chains;  ///< ends of each chain
  };
  class JoinedEnds;

  template <class Do>
  Result<void> for_each_piece(bool widened, Do&& work);
  /// Number of unknowns of a state, the same for all chains, because all vehicles of a site have the same
  /// kind of motion and clock.
  [[nodiscard]] int block_size() const { return like_.front().block_size(); }
  [[nodiscard]] bool is_mine(std::size_t piece) const { return piece >= first_ && piece < last_; }
  void extend_back(DriveWork& w) const;
  void restore(std::size_t piece, const Estimate& estimate, const std::vector<Node>& ends,
               DriveWork& w) const;
  void join_pieces(const std::vector<double>& numbers_of_ends);
  [[nodiscard]] std::pair<Node, Node> reach_by_odometry(std::size_t piece, bool forward, const Node& from);
  [[nodiscard]] std::vector<Node> ends_at(const Eigen::VectorXd& x) const;
  void solve_states(const DrivePiece& piece, const ParameterLayout& layout, const SharedState& state,
                    RejectionPolicy policy, PassCounts& counts, DriveWork& w, OpenChain& out) const;

  ReadingTask task_;
  const DriveIndex& index_;
  TrajectoryModel model_;
  std::size_t first_, last_;  ///< pieces of this rank
  std::vector<DriveWork> workers_;
  std::vector<KeptTrajectory> kept_;  ///< kept data of each piece
  std::vector<Trajectory> like_;      ///< for each chain, an empty trajectory with its kind of states
  PieceEnds from_, tried_;
};

}  // namespace octant::calib
