// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/adjust/tile.h"
#include "calib/problem/parameters.h"
#include "calib/sums/ranks.h"
#include "calib/sums/reduced_system.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Observations as an adjustment uses them: their cost, gradient and Gauss-Newton matrix, with solved vehicle
/// states.
class SystemSum {
 public:
  virtual ~SystemSum() = default;
  /// Solves for all states; returns the cost.
  virtual double solve_states(const SharedState& state, const RobustLoss& loss) = 0;
  /// Reduced system in all the layout's parameters at the states of the last `solve_states`.
  virtual void reduce(const SharedState& state, const RobustLoss& loss, ReducedSystem& sum) = 0;
  /// Makes the states of the last `solve_states` those to begin from.
  virtual void commit() {}

  /// At sites where few parameters share an observation, it is used by its parts, each of whole parameter
  /// blocks: their columns, ascending; their costs at the last `solve_states`; their systems.
  [[nodiscard]] virtual const std::vector<int>& columns_of(std::size_t part) const = 0;
  [[nodiscard]] virtual const std::vector<double>& costs() const = 0;
  [[nodiscard]] virtual std::vector<SystemPart> reduce_each(const SharedState& state,
                                                            const RobustLoss& loss) = 0;

 protected:
  SystemSum() = default;
  SystemSum(const SystemSum&) = default;
  SystemSum& operator=(const SystemSum&) = default;
};

/// All tiles of an adjustment, evaluated together. Sums are formed in an order that depends on the problem
/// alone: tiles are added up in a fixed number of shares, and the shares in their order (over ranks: to
/// rounding).
class TileSum : public SystemSum {
 public:
  TileSum(std::vector<Trajectory>& trajectories, const ParameterLayout& layout, const Workers& workers);

  /// Solves all states, starting from the committed ones; returns the cost. States of tiles of other ranks
  /// are unchanged here until `share_states`.
  double solve_states(const SharedState& state, const RobustLoss& loss) override;
  /// Reduced system of everything in all the layout's parameters, at the states of the last `solve_states`;
  /// commits them.
  void reduce(const SharedState& state, const RobustLoss& loss, ReducedSystem& sum) override;
  /// Each tile is a part. Commits the states.
  [[nodiscard]] std::vector<SystemPart> reduce_each(const SharedState& state,
                                                    const RobustLoss& loss) override;
  [[nodiscard]] const std::vector<int>& columns_of(std::size_t part) const override {
    return tiles_[part].columns();
  }
  [[nodiscard]] const std::vector<double>& costs() const override { return costs_; }
  /// Adds all of it by its parts, one after the other on this thread and this rank alone; commits the states.
  void reduce_onto(const SharedState& state, SystemParts& sum);
  /// Restores the states committed last, on every rank.
  void share_states();

  void commit() override;

  [[nodiscard]] const std::vector<Tile>& tiles() const { return tiles_; }

 private:
  [[nodiscard]] bool is_mine(std::size_t share) const;
  [[nodiscard]] std::size_t first_of(std::size_t share) const;
  template <class Work>
  void for_each_of_mine(Work&& work);
  /// Adds the parts of the other ranks, and fills both triangles.
  void complete(ReducedSystem& system) const;
  /// @param off  by how much each tile's cost was off, this rank's
  void correct_costs(std::vector<double>& off);

  const ParameterLayout& layout_;
  Workers workers_;
  std::vector<Tile> tiles_;
  std::vector<double> costs_;
  std::vector<ReducedSystem> shares_;
  std::vector<int> all_columns_;
};

}  // namespace octant::calib
