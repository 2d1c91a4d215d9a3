// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/stream/chunk_work.h"
#include "calib/stream/drive_index.h"
#include "calib/stream/end_chain.h"
#include "calib/stream/log_passes.h"
#include "calib/stream/log_readings.h"
#include "models/arrival_source.h"

namespace octant::calib {

/// Long planar drives that are read again for each look at them, piece by piece on several threads. Pieces
/// share the states at which they are cut. Each reading holds these, settles the states between them and
/// eliminates them onto their two ends and the parameters; then the ends go, one after the other, which is a
/// Gauss-Newton step of states and parameters together. Between the readings there remains where each state
/// is (24 bytes) and what became of each arrival (one byte). Every rank reads all.
class DrivePasses : public LogReadings {
 public:
  /// All must outlive it. @param frame  site and runs without arrivals
  DrivePasses(const Problem& frame, const ArrivalSource& source, const DriveIndex& index,
              const SolveOptions& options, int workers, Course& course);

  [[nodiscard]] Result<Placed> place(const Estimate& estimate, double suspect_sigmas, bool mark) override;
  [[nodiscard]] Result<PassSum> pass(const Estimate& estimate, MarkPolicy marks) override;
  void accept() override { from_ = tried_; }
  [[nodiscard]] Result<LogFindings> findings(const Estimate& estimate) override;

 private:
  struct PieceStates {
    std::vector<KeptState> state;
    std::vector<Rejection> marks;
  };
  /// The ends behind pieces and what they were linearised with.
  struct Ends {
    std::vector<KeptState> state;  ///< behind each piece
    Eigen::VectorXd x;             ///< where that was done; empty: nowhere
    std::vector<EndChain> chains;  ///< of each chain
  };
  struct Numbers;

  template <class Do>
  Result<void> for_each_piece(bool widened, Do&& work);
  void restore(std::size_t piece, double sigma_s, const std::vector<KeptState>& ends, DriveWork& w) const;
  void keep(std::size_t piece, const DriveWork& w, std::size_t first_node, std::size_t first_arrival);
  void join_pieces();
  void reach_by_odometry(std::size_t piece, bool forward);
  [[nodiscard]] std::vector<KeptState> ends_at(const Eigen::VectorXd& x) const;
  void settle(const DrivePiece& piece, const ParameterLayout& layout, const SharedState& state,
              MarkPolicy marks, Numbers& numbers, DriveWork& w, OpenChain& out) const;

  const Problem& frame_;
  const ArrivalSource& source_;
  const DriveIndex& index_;
  const SolveOptions& options_;
  Course& course_;
  TrajectoryModel model_;
  std::vector<DriveWork> workers_;
  std::vector<PieceStates> pieces_;
  Ends from_, tried_;
};

}  // namespace octant::calib
