// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/kept_states.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "calib/adjust/node_buffer.h"
#include "models/simulator/random.h"

namespace octant::test {
namespace kept_states_test {

Node any_node(Motion motion, Random& draws) {
  Node node;
  node.placed = true;
  node.T_map_vehicle = Pose::planar(20 * draws.normal(), 20 * draws.normal(), draws.uniform(-3.1, 3.1));
  if (motion == Motion::kSpatial) node.T_map_vehicle = {20 * draws.normal3(), exp_rotation(draws.normal3())};
  node.cycle_offset_s = draws.normal();
  node.velocity = draws.normal3();
  return node;
}

double off(const Pose& a, const Pose& b) {
  return (a.translation_m - b.translation_m).norm() + a.rotation.angularDistance(b.rotation);
}

RC_GTEST_PROP(KeptStates, ComeBackAsTheyWere, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  Trajectory like;
  like.motion = *rc::gen::element(Motion::kPlanar, Motion::kSpatial);
  like.has_cycle_offset = *rc::gen::arbitrary<bool>();
  if (like.motion == Motion::kPlanar && *rc::gen::arbitrary<bool>()) like.motion_prior.emplace();
  const int count = *rc::gen::inRange(1, 8);
  calib::KeptStates kept;
  kept.reserve(like, static_cast<std::size_t>(count));
  std::vector<Node> nodes;
  for (int i = 0; i < count; ++i) {
    nodes.push_back(any_node(like.motion, draws));
    nodes.back().placed = *rc::gen::arbitrary<bool>();
    kept.add(like, nodes.back());
  }
  for (std::size_t i = nodes.size(); i-- > 0;) {
    const Node before = any_node(like.motion, draws);
    Node node = before;
    kept.put(like, i, node);
    RC_ASSERT(node.placed == nodes[i].placed);
    if (!node.placed) {  // its numbers mean nothing, and are left
      RC_ASSERT(off(node.T_map_vehicle, before.T_map_vehicle) == 0.0);
      continue;
    }
    // A heading becomes a quaternion again: the root of a rounding.
    RC_ASSERT(off(node.T_map_vehicle, nodes[i].T_map_vehicle) < 1e-7);
    RC_ASSERT(node.cycle_offset_s == (like.has_cycle_offset ? nodes[i] : before).cycle_offset_s);
    RC_ASSERT(node.velocity == (like.motion_prior ? nodes[i] : before).velocity);
  }
}

TEST(KeptStates, MayBeginAnew) {
  Trajectory like;
  Random draws(1);
  calib::KeptStates kept;
  kept.add(like, any_node(Motion::kPlanar, draws));
  kept.clear();
  Node node = any_node(Motion::kPlanar, draws);
  node.placed = false;
  kept.add(like, node);
  Node back;
  back.placed = true;
  kept.put(like, 0, back);
  EXPECT_FALSE(back.placed);
}

/// Three states with one arrival and one bearing each, the last bearing at the very end.
Trajectory marked(Random& draws) {
  Trajectory t;
  for (std::size_t k = 0; k < 3; ++k) {
    t.nodes.push_back(any_node(Motion::kPlanar, draws));
    t.nodes.back().placed = true;
    t.arrivals.push_back({.node = static_cast<std::uint32_t>(k)});
    t.bearings.push_back({.node = k});
  }
  t.arrivals[1].rejection = Rejection::kLate;
  t.bearings[2].rejection = Rejection::kEarly;
  return t;
}

TEST(KeptTrajectory, ComesBackAsItWas) {
  Random draws(2);
  const Trajectory t = marked(draws);
  calib::KeptTrajectory kept;
  kept.keep(t);
  EXPECT_TRUE(kept.fits(t));
  Trajectory back = t;
  for (ArrivalObservation& a : back.arrivals) a.rejection = Rejection::kNoPose;
  for (BearingObservation& b : back.bearings) b.rejection = Rejection::kNoPose;
  back.nodes[1].T_map_vehicle = Pose();
  kept.restore(back);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(back.arrivals[k].rejection, t.arrivals[k].rejection);
    EXPECT_EQ(back.bearings[k].rejection, t.bearings[k].rejection);
    EXPECT_EQ(back.nodes[k].T_map_vehicle.translation_m, t.nodes[k].T_map_vehicle.translation_m);
  }
}

TEST(KeptTrajectory, MayBeAPartWhoseLastStateIsItsNeighboursFirst) {
  Random draws(3);
  const Trajectory t = marked(draws);
  calib::KeptTrajectory kept;
  kept.keep(t, 0, 2, 0, 2);  // the bearing at its last state is the neighbour's
  EXPECT_EQ(kept.rejections(),
            (std::vector<Rejection>{Rejection::kUsed, Rejection::kLate, Rejection::kUsed}));
  kept.keep(t, 1, 3, 1, 2);
  EXPECT_EQ(kept.rejections(), (std::vector<Rejection>{Rejection::kLate, Rejection::kUsed, Rejection::kUsed,
                                                       Rejection::kEarly}));
  EXPECT_FALSE(kept.fits(t));
}

RC_GTEST_PROP(NodeBuffer, TakesWhatWasPut, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  Node node = any_node(Motion::kSpatial, draws), back;
  node.placed = *rc::gen::arbitrary<bool>();
  std::vector<double> numbers;
  calib::BufferWriter(numbers).exchange(node);
  calib::BufferReader(numbers).exchange(back);
  RC_ASSERT(back.placed == node.placed);
  RC_ASSERT(back.T_map_vehicle.translation_m == node.T_map_vehicle.translation_m);
  RC_ASSERT(back.T_map_vehicle.rotation.coeffs() == node.T_map_vehicle.rotation.coeffs());
  RC_ASSERT(back.cycle_offset_s == node.cycle_offset_s);
  RC_ASSERT(back.velocity == node.velocity);
}

}  // namespace kept_states_test
}  // namespace octant::test
