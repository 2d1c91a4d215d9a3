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

/// The drives of a log, read again for each look at them, piece by piece on several threads. Pieces
/// share the states at which they are cut. Each reading holds these, solves for the states between them and
/// eliminates them onto their two ends and the parameters; then the ends go, one after the other, which is a
/// Gauss-Newton step of states and parameters together. Between the readings there remains where each state
/// is (24 bytes in the plane) and what became of each arrival (one byte); ranks keep those of their own
/// pieces and read no others, and tell each other of the ends.
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
  /// The ends behind pieces and what they were linearised with.
  struct PieceEnds {
    std::vector<Node> state;       ///< behind each piece
    Eigen::VectorXd x;             ///< where that was done; empty: nowhere
    std::vector<EndChain> chains;  ///< ends of each chain
  };
  class JoinedEnds;

  template <class Do>
  Result<void> for_each_piece(bool widened, Do&& work);
  /// Unknowns of a state, of whichever chain: all vehicles of a site move and keep time alike.
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
