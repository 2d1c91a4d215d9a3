// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "calib/chain/chain_reduction.h"
#include "calib/lanes/stop_block.h"
#include "calib/problem/parameters.h"
#include "calib/sums/reduced_system.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// A tile: some segments of one trajectory. For given shared parameters it first solves its own vehicle
/// states (variable projection), then eliminates them:
///   H = sum Js'Js - Js'Jx (Jx'Jx)^-1 Jx'Js,   g = Js'r - Js'Jx (Jx'Jx)^-1 Jx'r
/// With solved states, cost, gradient and Gauss-Newton matrix are those of the full bundle adjustment; the
/// remaining Jx'r is corrected to first order. Not safe to evaluate one tile from two threads; different
/// tiles are independent.
class Tile {
 public:
  /// @param trajectory  not owned; this tile writes only the nodes of its segments
  /// @param stops       segments for the vector kernel, which StopBlock supports
  /// @param arrivals    those of the stops; not kept, null without stops
  /// @param general     all other segments
  Tile(Trajectory* trajectory, std::vector<std::size_t> stops, const StopArrivals* arrivals,
       std::vector<std::size_t> general, const ParameterLayout* layout);

  [[nodiscard]] Trajectory& trajectory() const { return *trajectory_; }
  /// Calls visit(index) for each of its segments.
  template <class Visit>
  void for_each_segment(Visit&& visit) const {
    for (const std::size_t s : stop_segments_) visit(s);
    for (const std::size_t s : general_) visit(s);
  }

  /// Global columns of the parameter blocks that this tile touches, ascending; the order of its system.
  [[nodiscard]] const std::vector<int>& columns() const { return columns_; }

  /// Position of each column of the layout in columns(); -1: not in it.
  [[nodiscard]] const std::vector<int>& local_of() const { return local_of_; }

  /// Returns true if it contains a chain so long that threads share its work: such tiles are evaluated one by
  /// one.
  [[nodiscard]] bool is_long() const { return is_long_; }

  /// Solves for the states from where they were committed and returns the cost, of chains to the second order
  /// of what their last step gains. The trajectory shows them once they are committed and `rewind` was
  /// called.
  double solve_states(const SharedState& state, const RobustLoss& loss, int threads = 1);
  /// Adds gradient and lower triangle of H at the states of the last `solve_states`. `place` is the position
  /// of each column of the layout in the system.
  /// @return correction of the cost of that `solve_states`: chains are not solved completely, and this system
  /// predicts the remaining
  /// gain better than theirs
  double reduce(const SharedState& state, const RobustLoss& loss, const std::vector<int>& place,
                ReducedSystem& system, int threads = 1);
  /// Makes the states of the last evaluation the start of the next ones (a step was accepted).
  void commit();
  /// Back to the states committed last.
  void rewind();

 private:
  void find_columns();
  void rewind_general();

  Trajectory* trajectory_;
  const ParameterLayout* layout_;
  std::vector<int> columns_;
  std::vector<int> local_of_;                         ///< global column -> local, -1
  std::vector<std::size_t> stop_segments_, general_;  ///< segments of the vector kernel, all others
  std::vector<double> solved_costs_;                  ///< cost of each of the latter
  bool is_long_ = false;
  bool has_moved_ = true;  ///< nodes of the general segments may differ from the committed ones
  std::unique_ptr<StopBlock> stops_;
  std::unique_ptr<ChainReduction> chains_;  ///< reduction of the general segments
  std::vector<Node> committed_;             ///< nodes of the general segments
};

/// Tiles of all trajectories; their number does not depend on the number of threads, so neither does any sum.
[[nodiscard]] std::vector<Tile> make_tiles(std::vector<Trajectory>& trajectories,
                                           const ParameterLayout& layout, int threads = 1);

}  // namespace octant::calib
