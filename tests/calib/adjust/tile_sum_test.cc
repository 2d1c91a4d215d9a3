// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// All tiles together against one dense elimination of all rows.
#include "calib/adjust/tile_sum.h"

#include <mutex>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "tests/calib/adjust/near_truth.h"
#include "tests/calib/thread_team.h"

namespace octant::test {
namespace tile_sum_test {

calib::ReducedSystem reduced(const NearTruth& near, const calib::Workers& workers) {
  std::vector<Trajectory> trajectories = near.trajectories;
  calib::TileSum tiles(trajectories, near.layout, workers);
  calib::ReducedSystem sum;
  sum.cost = tiles.solve_states(near.here, {});
  tiles.reduce(near.here, {}, sum);
  sum.H = sum.H.selfadjointView<Eigen::Lower>();
  return sum;
}

TEST(TileSum, IsTheDenseEliminationOfAllStates) {
  for (const Scenario& scenario : {some_stops(), short_drive()}) {
    const NearTruth near(scenario);
    expect_same_system(reduced(near, {}), near.dense(), 1e-6);
  }
}

TEST(TileSum, DoesNotDependOnThreadsAndOnRanksByARounding) {
  Scenario scenario = some_stops();
  scenario.path.epochs = 1200;
  const NearTruth near(scenario);
  const calib::ReducedSystem one = reduced(near, {}), three = reduced(near, {.threads = 3});
  EXPECT_EQ(one.H, three.H);
  EXPECT_EQ(one.gradient, three.gradient);
  std::mutex mutex;
  for_each_rank(3, [&](const calib::Ranks& rank) {
    calib::Workers workers;
    workers.ranks = &rank;
    const calib::ReducedSystem here = reduced(near, workers);
    const std::lock_guard lock(mutex);
    expect_same_system(here, one, 1e-12);
  });
}

TEST(TileSum, OfEachTileAddUpToTheWhole) {
  Scenario scenario = some_stops();
  scenario.path.epochs = 1200;
  const NearTruth near(scenario);
  std::vector<Trajectory> trajectories = near.trajectories;
  calib::TileSum tiles(trajectories, near.layout, {});
  EXPECT_GT(tiles.tiles().size(), 1U);
  calib::ReducedSystem sum;
  sum.cost = tiles.solve_states(near.here, {});
  sum.H = Eigen::MatrixXd::Zero(near.layout.size(), near.layout.size());
  sum.gradient = Eigen::VectorXd::Zero(near.layout.size());
  const std::vector<calib::SystemPart> parts = tiles.reduce_each(near.here, {});
  ASSERT_EQ(parts.size(), tiles.tiles().size());
  double costs = 0.0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_EQ(parts[i].columns, tiles.columns_of(i));
    EXPECT_EQ(parts[i].system.cost, tiles.costs()[i]);
    sum.H(parts[i].columns, parts[i].columns) += parts[i].system.H;
    sum.gradient(parts[i].columns) += parts[i].system.gradient;
    costs += parts[i].system.cost;
  }
  EXPECT_NEAR(costs, sum.cost, 1e-9 * sum.cost);
  expect_same_system(sum, reduced(near, {}), 1e-10);
}

TEST(TileSum, ARankKeepsTheStatesOfOthersUntilTheyAreShared) {
  NearTruth near(some_stops());
  for (Trajectory& t : near.trajectories)
    for (Node& node : t.nodes) node.T_map_vehicle.translation_m += Eigen::Vector3d(0.02, -0.01, 0);
  std::vector<Trajectory> alone = near.trajectories;
  calib::TileSum tiles(alone, near.layout, {});
  static_cast<void>(tiles.solve_states(near.here, {}));
  tiles.commit();
  tiles.share_states();
  std::mutex mutex;
  for_each_rank(2, [&](const calib::Ranks& rank) {
    std::vector<Trajectory> mine = near.trajectories;
    calib::Workers workers;
    workers.ranks = &rank;
    calib::TileSum of_rank(mine, near.layout, workers);
    static_cast<void>(of_rank.solve_states(near.here, {}));
    of_rank.commit();
    of_rank.share_states();
    const std::lock_guard lock(mutex);
    for (std::size_t k = 0; k < alone[0].nodes.size(); ++k)
      EXPECT_EQ(mine[0].nodes[k].T_map_vehicle.translation_m, alone[0].nodes[k].T_map_vehicle.translation_m)
          << k;
  });
}

}  // namespace tile_sum_test
}  // namespace octant::test
