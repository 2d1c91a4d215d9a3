// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The vector kernel against the general path of the tile: same cost, gradient, matrix and states.
#include "calib/lanes/stop_block.h"

#include <cstdlib>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "calib/adjust/tile.h"
#include "models/simulator/random.h"
#include "tests/calib/adjust/evaluated_tile.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace stop_block_test {

/// A measured pose without weight, which makes the kernel leave the epoch to the general method.
void make_general(Trajectory& t) {
  const std::vector<PoseObservation> measured = std::exchange(t.poses, {});
  for (Segment& s : t.segments) {
    const std::size_t first = t.poses.size();
    t.poses.insert(t.poses.end(), measured.begin() + static_cast<std::ptrdiff_t>(s.first_pose),
                   measured.begin() + static_cast<std::ptrdiff_t>(s.last_pose));
    t.poses.insert(t.poses.end(), 2, {s.first_node, 0.0, Pose(), INFINITY, INFINITY, INFINITY});
    s.first_pose = first;
    s.last_pose = t.poses.size();
  }
}

/// Measures the poses of a third of the stops, and the headings of another third. The headings are
/// inaccurate, so that the half turn at which headings wrap is often between the measured and the estimated
/// one.
void measure_poses(Trajectory& t) {
  Random draws(5);
  for (std::size_t i = 0; i < t.segments.size(); ++i) {
    Segment& s = t.segments[i];
    s.first_pose = t.poses.size();
    const Pose& at = t.nodes[s.first_node].T_map_vehicle;
    const auto told = [&](double by_rad) {
      return Pose::planar(at.translation_m.x() + 0.02 * draws.normal(), at.translation_m.y(),
                          at.heading_rad() + by_rad);
    };
    if (i % 3 == 0) t.poses.push_back({s.first_node, 0.0, told(0.05 * draws.normal()), 0.02, 0.05, INFINITY});
    if (i % 3 == 1)
      t.poses.push_back({s.first_node, 0.0, told(i % 2 == 0 ? 1.5 : -1.5), INFINITY, 1.0, INFINITY});
    s.last_pose = t.poses.size();
  }
}

/// All of a small hall's stops are one tile.
calib::Tile only_tile(std::vector<Trajectory>& trajectories, const calib::ParameterLayout& layout) {
  std::vector<calib::Tile> tiles = calib::make_tiles(trajectories, layout);
  EXPECT_EQ(tiles.size(), 1U);
  return std::move(tiles.front());
}

struct Sides {
  calib::Problem problem;
  calib::ParameterLayout layout;
  SharedState state;
  std::vector<Trajectory> fast, general;
};

Sides sides_of(const Scenario& scenario, double rough_m, bool measured = false) {
  const World world = must(simulate(scenario, 7));
  Sides out{problem_of(world), {}, shared_state(world.truth), {}, {}};
  out.state.speed_offset_mps[0] += 0.05;
  for (Eigen::Vector3d& p : out.state.beacon_p_map_m) p += Eigen::Vector3d(0.01, -0.02, 0.015);
  out.layout = calib::make_layout(out.problem, out.state);
  out.fast = out.problem.trajectories;
  Random draws(3);
  for (Trajectory& t : out.fast)
    for (Node& node : t.nodes) {
      EXPECT_TRUE(interpolate_poses(world.run.truth, node.time_s, 1.0, node.T_map_vehicle));
      node.T_map_vehicle = retract(node.T_map_vehicle, rough_m * draws.normal3(), Motion::kPlanar);
      node.cycle_offset_s = t.has_cycle_offset ? t.arrivals[0].tof_s - 0.02 : 0.0;
      node.placed = true;
    }
  out.fast[0].arrivals[5].rejection = Rejection::kLate;
  if (measured) measure_poses(out.fast[0]);
  out.general = out.fast;
  for (Trajectory& t : out.general) make_general(t);
  return out;
}

void expect_same(Sides& s, const RobustLoss& loss) {
  ASSERT_TRUE(calib::StopBlock::knows(s.fast[0], s.layout));
  ASSERT_TRUE(calib::StopBlock::takes(s.fast[0], s.fast[0].segments[0]));
  ASSERT_FALSE(calib::StopBlock::takes(s.general[0], s.general[0].segments[0]));
  calib::Tile fast = only_tile(s.fast, s.layout), general = only_tile(s.general, s.layout);
  calib::ReducedSystem a, b;
  // Under a redescending loss states converge slowly, in more steps than one evaluation has.
  for (calib::Tile* tile : {&fast, &general})
    for (int again = 0; again < 4; ++again) {
      evaluated(*tile, s.state, loss);
      tile->commit();
    }
  const double cost = evaluated(fast, s.state, loss, &a), expected = evaluated(general, s.state, loss, &b);
  // Both stop where a step would gain a part in 1e13 of the cost.
  EXPECT_NEAR(cost, expected, 1e-10 * expected);
  EXPECT_NEAR(a.cost, cost, 1e-12 * cost);
  ASSERT_EQ(a.H.rows(), b.H.rows());
  for (calib::Tile* tile : {&fast, &general}) {
    tile->commit();
    tile->rewind();
  }
  // The remainder of a direction that the states absorb (the rotation of an array) is rounding error of the
  // original.
  const double rounding = 1e-13 * b.H.diagonal().maxCoeff();
  for (Eigen::Index i = 0; i < a.H.rows(); ++i) {
    // An error of a state that corresponds to the remaining gain changes the gradient by about its root.
    EXPECT_NEAR(a.gradient[i], b.gradient[i], 1e-4 * std::sqrt(b.H(i, i) * expected) + rounding) << i;
    for (Eigen::Index j = 0; j < a.H.cols(); ++j)
      EXPECT_NEAR(a.H(i, j), b.H(i, j), 1e-6 * std::sqrt(b.H(i, i) * b.H(j, j)) + rounding)
          << "columns " << i << ", " << j;
  }
  for (std::size_t k = 0; k < s.fast[0].nodes.size(); ++k) {
    const Pose &p = s.fast[0].nodes[k].T_map_vehicle, &q = s.general[0].nodes[k].T_map_vehicle;
    EXPECT_LT((p.translation_m - q.translation_m).norm(), 1e-6) << k;
    EXPECT_LT(std::abs(wrap_angle(p.heading_rad() - q.heading_rad())), 1e-5) << k;
  }
}

void expect_same(const Scenario& scenario, const RobustLoss& loss) {
  Sides s = sides_of(scenario, 0.05);
  expect_same(s, loss);
}

Scenario small_hall(int epochs = 37) {  // no multiple of the lanes
  Scenario s = hall_scenario();
  s.path.epochs = epochs;
  s.site.timing.delay_per = {.beacon = true, .receiver = true, .site = true};
  return s;
}

TEST(StopBlock, GivesWhatTheGeneralPathGives) {
  expect_same(small_hall(), {});
  expect_same(small_hall(), {2.385, 2.385});
  expect_same(small_hall(), {10.0, 15.0});
}

/// One binary, every instruction set that this machine has: narrower vectors take the eight lanes in turns.
TEST(StopBlock, EveryInstructionSetGivesTheSame) {
  struct AllTargets {
    ~AllTargets() { hwy::SetSupportedTargetsForTest(0); }
  } afterwards;
  Scenario offset = small_hall();
  offset.site.timing.clock = Clock::kCycleOffset;
  offset.site.timing.delay_per = {};
  offset.true_delay_s.reset();
  std::set<std::string> names;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    hwy::SetSupportedTargetsForTest(left & -left);
    names.insert(calib::stop_kernel_target());
    SCOPED_TRACE(calib::stop_kernel_target());
    expect_same(small_hall(), {});
    expect_same(small_hall(), {2.385, 2.385});
    expect_same(offset, {2.385, 2.385});
  }
  if (std::getenv("OCTANT_SIMD") == nullptr)
    EXPECT_GE(names.size(), 2U);  // x86-64 has SSE2 at least, and some more
}

/// Several arrivals over one path in an epoch, and epochs with hardly any arrivals, in one pack with others.
TEST(StopBlock, RepeatedArrivalsAndLonelyOnes) {
  Sides s = sides_of(small_hall(21), 0.02);
  for (std::vector<Trajectory>* side : {&s.fast, &s.general}) {
    Trajectory& t = side->front();
    for (std::size_t i = t.segments[4].first_arrival; i < t.segments[4].last_arrival; ++i)
      if (i > t.segments[4].first_arrival + 6) t.arrivals[i].rejection = Rejection::kLate;
    Trajectory repeated = t;
    repeated.arrivals.clear();
    for (std::size_t k = 0; k < t.segments.size(); ++k) {
      Segment& to = repeated.segments[k];
      to.first_arrival = repeated.arrivals.size();
      for (int again = 0; again < (k % 3 == 0 ? 3 : 1); ++again)
        for (std::size_t i = t.segments[k].first_arrival; i < t.segments[k].last_arrival; ++i) {
          repeated.arrivals.push_back(t.arrivals[i]);
          repeated.arrivals.back().tof_s += 3e-6 * again;
        }
      to.last_arrival = repeated.arrivals.size();
    }
    t = repeated;
  }
  expect_same(s, {});
}

TEST(StopBlock, CycleOffset) {
  Scenario s = small_hall();
  s.site.timing.clock = Clock::kCycleOffset;
  s.site.timing.delay_per = {};
  s.true_delay_s.reset();
  expect_same(s, {});
  expect_same(s, {2.385, 2.385});
}

TEST(StopBlock, ArrayAsOnePieceAndTemperatures) {
  Scenario s = small_hall();
  for (SiteReceiver& r : s.site.receivers) r.sigma_m.setZero();
  s.site.vehicles[0].array = ArrayShape{0.002, 0.02};
  s.warming_degC = 5.0;
  expect_same(s, {});
}

TEST(StopBlock, EpochsOutOfReachAreLeftToTheGeneralPath) {
  Sides s = sides_of(small_hall(16), 0.0);
  s.fast[0].nodes[3].T_map_vehicle.translation_m +=
      Eigen::Vector3d(30.0, -20.0, 0.0);  // far outside the hall
  s.general[0].nodes[3].T_map_vehicle = s.fast[0].nodes[3].T_map_vehicle;
  calib::Tile fast = only_tile(s.fast, s.layout), general = only_tile(s.general, s.layout);
  const double cost = evaluated(fast, s.state, {2.385, 2.385}),
               expected = evaluated(general, s.state, {2.385, 2.385});
  EXPECT_NEAR(cost, expected, 1e-6 * expected);
}

TEST(StopBlock, MeasuredPosesAndHeadings) {
  const auto compare = [](const Scenario& scenario, const RobustLoss& loss) {
    Sides s = sides_of(scenario, 0.01, true);
    for (const std::size_t i : {0U, 1U, 2U})
      EXPECT_TRUE(calib::StopBlock::takes(s.fast[0], s.fast[0].segments[i])) << i;
    expect_same(s, loss);
  };
  Scenario scenario = small_hall();
  compare(scenario, {});
  compare(scenario, {2.385, 2.385});
  scenario.site.timing.clock = Clock::kCycleOffset;
  scenario.site.timing.delay_per = {.receiver = true};
  compare(scenario, {});  // a robust loss with headings half a turn off has several minima
}

TEST(StopBlock, WhatItDoesNotKnowIsLeftAlone) {
  Scenario s = hall_scenario();
  s.path.epochs = 3;
  add_attenuation(s);
  Sides sides = sides_of(s, 0.0);
  EXPECT_FALSE(calib::StopBlock::knows(sides.fast[0], sides.layout));
}

}  // namespace stop_block_test
}  // namespace octant::test
