// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/kept_states.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "calib/adjust/node_numbers.h"
#include "models/simulator/random.h"

namespace octant::test {
namespace {

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
    RC_ASSERT(kept.has_place(like, i) == nodes[i].placed);
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
  EXPECT_FALSE(kept.has_place(like, 0));
}

RC_GTEST_PROP(NodeNumbers, TakeWhatWasPut, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  Node node = any_node(Motion::kSpatial, draws), back;
  node.placed = *rc::gen::arbitrary<bool>();
  double numbers[calib::kNumbersOfNode];
  calib::put_numbers(node, numbers);
  calib::read_numbers(numbers, back);
  RC_ASSERT(back.placed == node.placed);
  RC_ASSERT(back.T_map_vehicle.translation_m == node.T_map_vehicle.translation_m);
  RC_ASSERT(back.T_map_vehicle.rotation.coeffs() == node.T_map_vehicle.rotation.coeffs());
  RC_ASSERT(back.cycle_offset_s == node.cycle_offset_s);
  RC_ASSERT(back.velocity == node.velocity);
}

}  // namespace
}  // namespace octant::test
