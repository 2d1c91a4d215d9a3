// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/solve_states.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "models/trajectory/linearise.h"

namespace octant {
namespace solve_states_test {

struct Drive {
  Trajectory t;
  SharedState state;
};

/// A long drive in the plane with plain arrivals and odometry, with errors of its states of centimetres.
Drive long_plain_drive(std::size_t nodes) {
  Drive drive;
  std::mt19937 random(11);
  std::normal_distribution<double> n;
  Trajectory& t = drive.t;
  for (int b = 0; b < 3; ++b) {
    drive.state.beacon_p_map_m.emplace_back(4.0 * b, 3.0 + n(random), 2.0 + 0.2 * b);
    drive.state.beacon_delay_s.push_back(1e-4);
  }
  drive.state.receiver_p_vehicle_m = {{0.2, 0.05, 0.3}, {-0.2, 0.1, 0.35}};
  drive.state.receiver_delay_s = {0.0, 1e-5};
  for (std::size_t k = 0; k < nodes; ++k) {
    const double a = 0.02 * static_cast<double>(k);
    Node node;
    node.placed = true;
    node.T_map_vehicle = Pose::planar(4 + 2 * std::cos(a), -1 + std::sin(a), 3 * a);
    t.nodes.push_back(node);
  }
  for (std::size_t k = 0; k + 1 < nodes; ++k) {
    ArrivalObservation a;
    a.node = static_cast<std::uint32_t>(k);
    a.alpha = 0.1 * static_cast<double>(k % 10);
    a.beacon = BeaconId(k % 3);
    a.receiver = ReceiverId(k % 2);
    a.sigma_s = 1e-5;
    a.model_speed_mps = 343.0;
    a.tof_s = -1e-5 * (arrival_residual(t, a, drive.state) + n(random));
    t.arrivals.push_back(a);
    const Pose step = t.nodes[k].T_map_vehicle.inverse() * t.nodes[k + 1].T_map_vehicle;
    t.odometry.push_back(
        {k, step * Pose::planar(1e-3 * n(random), 1e-3 * n(random), 1e-3 * n(random)), 1e-3, 1e-3});
  }
  t.poses.push_back({(nodes - 1) / 2, 0.5, t.nodes[(nodes - 1) / 2].T_map_vehicle, 0.01, 0.02, 0.03});
  t.bearings.push_back({(nodes - 1) / 3, 0.5, 0, BeaconId(1), 0.7, 0.5, Rejection::kUsed});
  t.segments.push_back({0, nodes, 0, t.arrivals.size(), 0, 1, 0, 1, 0, t.odometry.size()});
  for (Node& node : t.nodes)
    node.T_map_vehicle = retract(
        node.T_map_vehicle, Eigen::Vector3d(0.02 * n(random), 0.02 * n(random), 0.02 * n(random)), t.motion);
  return drive;
}

/// In space: no bearings, and rotations about all axes.
Drive long_spatial_drive(std::size_t nodes) {
  Drive drive = long_plain_drive(nodes);
  std::mt19937 random(12);
  std::normal_distribution<double> n;
  const auto draw = [&] { return Eigen::Vector3d(n(random), n(random), n(random)); };
  Trajectory& t = drive.t;
  t.motion = Motion::kSpatial;
  t.bearings.clear();
  t.segments[0].last_bearing = 0;
  for (std::size_t k = 0; k < nodes; ++k) {
    const double a = 0.02 * static_cast<double>(k);
    t.nodes[k].T_map_vehicle.translation_m = {4 + 2 * std::cos(a), -1 + std::sin(a), std::sin(0.3 * a)};
    t.nodes[k].T_map_vehicle.rotation =
        exp_rotation({0.2 * std::sin(a), 0.3 * std::cos(a), std::sin(0.7 * a)});
  }
  for (ArrivalObservation& a : t.arrivals)
    a.tof_s -= 1e-5 * (arrival_residual(t, a, drive.state) + n(random));
  for (OdometryObservation& o : t.odometry)
    o.T_before_after = t.nodes[o.node].T_map_vehicle.inverse() * t.nodes[o.node + 1].T_map_vehicle *
                       Pose{1e-3 * draw(), exp_rotation(1e-3 * draw())};
  t.poses[0].T_map_vehicle = t.nodes[t.poses[0].node].T_map_vehicle;
  for (Node& node : t.nodes) {
    Eigen::VectorXd off(6);
    off << 0.02 * draw(), 0.02 * draw();
    node.T_map_vehicle = retract(node.T_map_vehicle, off, t.motion);
  }
  return drive;
}

TEST(SpatialChain, SettlesWhereTheRowsHaveNoGradient) {
  for (const std::size_t nodes : {std::size_t{2}, std::size_t{50}, std::size_t{3000}})
    for (const RobustLoss& loss : {RobustLoss{}, RobustLoss{4.0, 5.0}}) {
      Drive drive = long_spatial_drive(nodes);
      const StateSolveResult result =
          solve_states(drive.t, drive.t.segments[0], drive.state, loss, {.max_iterations = 100});
      EXPECT_TRUE(result.converged);
      if (is_plain(loss)) EXPECT_LE(result.iterations, 6) << "that is not Gauss-Newton";
      ChainSystem system;
      build_chain_system(drive.t, drive.t.segments[0], drive.state, loss, system);
      EXPECT_NEAR(result.cost, system.cost, 1e-9 * system.cost);
      for (std::size_t k = 0; k < system.g.size(); ++k)
        EXPECT_LT(system.g[k].norm(), 1e-3 * std::sqrt(system.D[k].trace())) << "gradient left at " << k;
    }
}

TEST(SpatialChain, DoesNotDependOnTheNumberOfThreads) {
  Drive one = long_spatial_drive(3000), three = one;
  const StateSolveResult a = solve_states(one.t, one.t.segments[0], one.state, {2.0, 3.0}, {.threads = 1});
  const StateSolveResult b =
      solve_states(three.t, three.t.segments[0], three.state, {2.0, 3.0}, {.threads = 3});
  EXPECT_EQ(a.cost, b.cost);
  for (std::size_t k = 0; k < one.t.nodes.size(); ++k) {
    EXPECT_EQ(one.t.nodes[k].T_map_vehicle.translation_m, three.t.nodes[k].T_map_vehicle.translation_m);
    EXPECT_EQ(one.t.nodes[k].T_map_vehicle.rotation.coeffs(),
              three.t.nodes[k].T_map_vehicle.rotation.coeffs());
  }
}

/// Far from the solution, steps are undone, and the system is built again for a shorter one.
TEST(SpatialChain, NoStepLeadsUphill) {
  Drive far = long_spatial_drive(60);
  Eigen::VectorXd off = Eigen::VectorXd::Zero(6);
  for (std::size_t k = 0; k < far.t.nodes.size(); ++k) {
    off[0] = 4.0 * std::sin(3.0 * static_cast<double>(k));
    off[3] = 2.0 * std::cos(2.0 * static_cast<double>(k));
    off[5] = 2.0 * std::sin(static_cast<double>(k));
    far.t.nodes[k].T_map_vehicle = retract(far.t.nodes[k].T_map_vehicle, off, far.t.motion);
  }
  double before = chain_cost(far.t, far.t.segments[0], far.state, {});
  for (int steps = 1; steps <= 30; ++steps) {
    Drive drive = far;
    const StateSolveResult result =
        solve_states(drive.t, drive.t.segments[0], drive.state, {}, {.max_iterations = steps});
    const double cost = chain_cost(drive.t, drive.t.segments[0], drive.state, {});
    EXPECT_NEAR(result.cost, cost, 1e-9 * cost) << steps;
    EXPECT_LE(cost, before * (1 + 1e-9)) << steps;
    before = cost;
  }
}

TEST(PlanarChain, SettlesWhereTheRowsHaveNoGradient) {
  for (const std::size_t nodes : {std::size_t{2}, std::size_t{50}, std::size_t{9000}}) {
    Drive drive = long_plain_drive(nodes);
    const StateSolveResult result =
        solve_states(drive.t, drive.t.segments[0], drive.state, {}, {.max_iterations = 100});
    EXPECT_TRUE(result.converged);
    ChainSystem system;
    build_chain_system(drive.t, drive.t.segments[0], drive.state, {}, system);
    EXPECT_NEAR(result.cost, system.cost, 1e-9 * system.cost);
    for (std::size_t k = 0; k < system.g.size(); ++k)
      EXPECT_LT(system.g[k].norm(), 1e-3 * std::sqrt(system.D[k].trace())) << "gradient left at node " << k;
  }
}

TEST(PlanarChain, DoesNotDependOnTheNumberOfThreads) {
  Drive one = long_plain_drive(9000), three = one;
  const StateSolveResult a = solve_states(one.t, one.t.segments[0], one.state, {2.0, 3.0}, {.threads = 1});
  const StateSolveResult b =
      solve_states(three.t, three.t.segments[0], three.state, {2.0, 3.0}, {.threads = 3});
  EXPECT_EQ(a.cost, b.cost);
  for (std::size_t k = 0; k < one.t.nodes.size(); ++k)
    EXPECT_EQ(one.t.nodes[k].T_map_vehicle.translation_m, three.t.nodes[k].T_map_vehicle.translation_m);
}

TEST(PlanarChain, LastStepTakenOnTrustCostsNothing) {
  Drive whole = long_plain_drive(3000), early = whole;
  const StateSolveResult a = solve_states(whole.t, whole.t.segments[0], whole.state, {});
  const StateSolveResult b = solve_states(early.t, early.t.segments[0], early.state, {}, {.tolerance = 1e-6});
  EXPECT_LT(b.iterations, a.iterations);
  EXPECT_NEAR(a.cost, b.cost, 1e-6 * a.cost);
  ChainSystem system;
  build_chain_system(early.t, early.t.segments[0], early.state, {}, system);
  EXPECT_NEAR(system.cost, a.cost, 1e-6 * a.cost);
}

/// The drive at rest, then its beacons moved: where its states rest now, and where one step leads.
struct Moved {
  Drive drive;
  StateSolveResult at_rest, one_step;
  double cost = 0.0;  ///< where the one step leads
};
Moved move_beacons(double by_m, const RobustLoss& loss) {
  Moved out{long_plain_drive(3000), {}, {}};
  Drive& drive = out.drive;
  solve_states(drive.t, drive.t.segments[0], drive.state, loss);
  for (std::size_t b = 0; b < drive.state.beacon_p_map_m.size(); ++b)
    drive.state.beacon_p_map_m[b] +=
        by_m * Eigen::Vector3d(std::sin(1.0 + static_cast<double>(b)), std::cos(static_cast<double>(b)), 0.5);
  Drive whole = drive;
  out.at_rest = solve_states(whole.t, whole.t.segments[0], whole.state, loss);
  out.one_step = solve_states(drive.t, drive.t.segments[0], drive.state, loss, {.left_behind = 0.01});
  out.cost = chain_cost(drive.t, drive.t.segments[0], drive.state, loss);
  return out;
}

TEST(PlanarChain, AShortStepIsTheLast) {
  const Moved near = move_beacons(0.01, {});
  EXPECT_GT(near.at_rest.iterations, 1);
  EXPECT_EQ(near.one_step.iterations, 0);
  EXPECT_LT(near.cost - near.at_rest.cost, 0.01 * near.at_rest.cost);
  EXPECT_NEAR(near.one_step.cost, near.at_rest.cost, 1e-3 * near.at_rest.cost);
}

TEST(PlanarChain, ALongStepIsNotTheLastNorIsOneWithARobustLoss) {
  const Moved far = move_beacons(0.5, {});
  EXPECT_GT(far.one_step.iterations, 0);
  EXPECT_LT(far.cost - far.at_rest.cost, 0.01 * far.at_rest.cost);
  const Moved robust = move_beacons(0.01, {2.0, 3.0});
  EXPECT_EQ(robust.one_step.iterations, robust.at_rest.iterations);
}

}  // namespace solve_states_test
}  // namespace octant
