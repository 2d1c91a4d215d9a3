// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Rows by the shared numbers, and what trajectory_test.cc has not: interpolation far from small turns, the
// motion prior, and the chain's system against a dense one.
#include "models/trajectory/linearise.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"
#include "tests/support/numeric.h"

namespace octant::test {
namespace linearise_test {

Random any_draws() { return Random(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>())); }

Pose any_pose(Motion motion, Random& draws) {
  if (motion == Motion::kPlanar)
    return Pose::planar(5 * draws.normal(), 5 * draws.normal(), draws.uniform(-3, 3));
  return {5 * draws.normal3(), exp_rotation(draws.normal3())};
}

/// Two states and an arrival between them, with every dependence that a path may have.
struct OneArrival {
  Trajectory t;
  SharedState state;

  OneArrival(Motion motion, bool cycle_offset, bool two_way, bool directional, Random& draws) {
    t.motion = motion;
    t.vehicle = VehicleId(0);
    t.has_cycle_offset = cycle_offset;
    t.turnaround_s = 0.01;
    t.nodes.resize(2);
    t.nodes[0].T_map_vehicle = any_pose(motion, draws);
    const Pose step = motion == Motion::kPlanar ? Pose::planar(0.5, 0.1, 0.4)
                                                : Pose{{0.5, 0.1, 0.2}, exp_rotation({0.3, -0.2, 0.4})};
    t.nodes[1].T_map_vehicle = t.nodes[0].T_map_vehicle * step;
    t.nodes[0].time_s = 3.0;
    t.nodes[1].time_s = 4.0;
    state.beacon_p_map_m = {t.nodes[0].T_map_vehicle * Eigen::Vector3d(4, 2, 3)};
    state.beacon_delay_s = {1e-4};
    state.beacon_log_gain = {0.1};
    state.receiver_p_vehicle_m = {{0.3, -0.2, 0.4}};
    state.receiver_delay_s = {1e-5};
    state.pair_bias_s = {1e-6};
    state.speed_offset_mps = {1.5};
    state.clock_drift = {2e-5};
    state.attenuation = AttenuationModel{12.5, 0.1, 0.05, 4e-4};
    if (directional) {
      state.attenuation->half_power_angle_rad = 0.8;
      state.receiver_axis = {Eigen::Vector3d(1, 0.2, 0.1).normalized()};
    }
    ArrivalObservation a;
    a.alpha = 0.3;
    a.time_s = 3.3;
    a.beacon = BeaconId(0);
    a.receiver = ReceiverId(0);
    a.tof_s = 0.016;
    a.sigma_s = 1e-5;
    a.model_speed_mps = 343.0;
    a.log_amplitude = 0.9;
    a.log_amplitude_sigma = 0.05;
    a.two_way = two_way;
    if (two_way) {
      a.hear_send = 0;
      t.T_hear_send = {any_pose(motion, draws)};
      t.T_hear_send[0].translation_m *= 0.02;
    }
    t.arrivals = {a};
  }
  [[nodiscard]] Eigen::VectorXd residuals() const {
    ObservationRow rows[2];
    const int count = arrival_rows(t, 0, state, rows);
    return Eigen::Vector2d(rows[0].residual, count > 1 ? rows[1].residual : 0.0);
  }
  /// Derivative of both rows by a number of the state.
  [[nodiscard]] Eigen::Vector2d by(double& number, double step) {
    const double value = number;
    number = value + step;
    const Eigen::Vector2d high = residuals();
    number = value - step;
    const Eigen::Vector2d low = residuals();
    number = value;
    return (high - low) / (2 * step);
  }
};

// Whitened times change by 300 a metre and 1e5 a second: the differences lose ten of sixteen digits.
void expect_near(double a, double b, double scale) { RC_ASSERT(std::abs(a - b) <= 2e-6 * scale); }

RC_GTEST_PROP(ArrivalRows, BySharedNumbersAgreeWithNumericOnes, ()) {
  Random draws = any_draws();
  const Motion motion = *rc::gen::element(Motion::kPlanar, Motion::kSpatial);
  OneArrival one(motion, *rc::gen::arbitrary<bool>(), *rc::gen::arbitrary<bool>(),
                 *rc::gen::arbitrary<bool>(), draws);
  ObservationRow rows[2];
  RC_ASSERT(arrival_rows(one.t, 0, one.state, rows) == 2);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Vector2d beacon = one.by(one.state.beacon_p_map_m[0][i], 1e-5),
                          receiver = one.by(one.state.receiver_p_vehicle_m[0][i], 1e-5);
    for (int r = 0; r < 2; ++r) {
      expect_near(rows[r].by_beacon[i], beacon[r], 300.0);
      expect_near(rows[r].by_receiver[i], receiver[r], 300.0);
    }
  }
  // All delays have equal derivatives: the beacon's, the receiver's, the site's, the pair's.
  for (double* delay : {&one.state.beacon_delay_s[0], &one.state.receiver_delay_s[0], &one.state.site_delay_s,
                        &one.state.pair_bias_s[0]}) {
    const Eigen::Vector2d by = one.by(*delay, 1e-7);
    expect_near(rows[0].by(kByDelay), by[0], 1e5);
    RC_ASSERT(by[1] == rows[1].by(kByDelay));
  }
  expect_near(rows[0].by(kBySpeed), one.by(one.state.speed_offset_mps[0], 1e-3)[0], 10.0);
  expect_near(rows[0].by(kByDrift), one.by(one.state.clock_drift[0], 1e-6)[0], 1e5);
  const double scale[] = {1.0, 1e2, 1e5, 1e2}, step[] = {1e-4, 1e-5, 1e-8, 1e-5};
  for (std::size_t i = 0; i < (one.state.attenuation->directional() ? 4U : 3U); ++i) {
    const Eigen::Vector2d by = one.by(attenuation_unknown(*one.state.attenuation, i), step[i]);
    for (int r = 0; r < 2; ++r)
      expect_near(rows[r].by_attenuation[static_cast<Eigen::Index>(i)], by[r], scale[i]);
  }
}

// At one state, at another, between them, and with every dependence that a path may have.
RC_GTEST_PROP(ArrivalResiduals, AreThoseOfEachArrivalByItself, ()) {
  Random draws = any_draws();
  for (const Motion motion : {Motion::kPlanar, Motion::kSpatial})
    for (const bool cycle_offset : {false, true})
      for (const bool two_way : {false, true})
        for (const bool directional : {false, true}) {
          OneArrival world(motion, cycle_offset, two_way, directional, draws);
          if (!directional) world.state.attenuation.reset();
          ArrivalResiduals residual_of(world.t, world.state);
          ArrivalObservation a = world.t.arrivals[0];
          for (const std::size_t node : {0, 0, 1, 0})
            for (const double alpha : {0.0, 0.4}) {
              a.node = alpha > 0.0 ? 0 : node;
              a.alpha = alpha;
              const double residual = arrival_residual(world.t, a, world.state);
              RC_ASSERT(std::abs(residual_of(a) - residual) < 1e-9 * (1 + std::abs(residual)));
            }
        }
}

TEST(ArrivalRows, AnAmplitudeThatWasNotLoggedIsNoRow) {
  Random draws(1);
  OneArrival one(Motion::kPlanar, false, false, false, draws);
  ObservationRow rows[2];
  one.t.arrivals[0].log_amplitude_sigma = 0.0;
  EXPECT_EQ(arrival_rows(one.t, 0, one.state, rows), 1);
  one.t.arrivals[0].log_amplitude_sigma = 0.05;
  one.state.attenuation.reset();
  EXPECT_EQ(arrival_rows(one.t, 0, one.state, rows), 1);
  EXPECT_EQ(rows[0].by(kByDrift), 0.0) << "no cycle, no drift";
}

TEST(ArrivalRows, AtAStateTouchItAlone) {
  Random draws(2);
  for (const Motion motion : {Motion::kPlanar, Motion::kSpatial}) {
    OneArrival one(motion, false, false, false, draws);
    one.t.arrivals[0].alpha = 0.0;
    ObservationRow rows[2];
    static_cast<void>(arrival_rows(one.t, 0, one.state, rows));
    EXPECT_FALSE(rows[0].has_next);
    EXPECT_EQ(rows[0].by_next.norm(), 0.0);
    EXPECT_GT(rows[0].by_node.norm(), 0.0);
  }
}

// --- Between two states --------------------------------------------------------------------------------

RC_GTEST_PROP(InterpolationJacobian, IsTheDerivativeOfPoseAt, ()) {
  Random draws = any_draws();
  Trajectory t;
  t.motion = Motion::kSpatial;
  t.nodes.resize(2);
  t.nodes[0].T_map_vehicle = any_pose(Motion::kSpatial, draws);
  Eigen::Vector3d turn = draws.normal3();
  if (turn.norm() > 3.0) turn *= 3.0 / turn.norm();  // short of half a turn, where the way round changes
  t.nodes[1].T_map_vehicle = t.nodes[0].T_map_vehicle * Pose{draws.normal3(), exp_rotation(turn)};
  const double alpha = draws.uniform(0.01, 1.0);
  const Pose here = pose_at(t, 0, alpha);
  const auto tangent = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    Trajectory moved = t;
    for (const int k : {0, 1}) {
      Pose& T = moved.nodes[static_cast<std::size_t>(k)].T_map_vehicle;
      T = retract(T, d.segment<6>(6 * k), Motion::kSpatial);
    }
    const Pose there = pose_at(moved, 0, alpha);
    Eigen::VectorXd v(6);
    v << there.translation_m - here.translation_m, log_rotation(here.rotation.conjugate() * there.rotation);
    return v;
  };
  InstantPose at;
  at.set(t, 0, 0.3 * alpha);  // of another instant of the same step, of which something is kept
  at.set(t, 0, alpha);
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(6, 12);
  both.topLeftCorner(3, 3).diagonal().setConstant(1 - alpha);
  both.block(0, 6, 3, 3).diagonal().setConstant(alpha);
  both.block(3, 3, 3, 3) = at.turn_by_node;
  both.block(3, 9, 3, 3) = at.turn_by_next;
  // Central differences with 1e-5; the inverse right Jacobian grows to some ten towards half a turn.
  RC_ASSERT((both - numeric_jacobian(tangent, Eigen::VectorXd::Zero(12), 1e-5)).cwiseAbs().maxCoeff() < 1e-7);
}

TEST(PoseAt, EndsAreTheStates) {
  Random draws(3);
  Trajectory t;
  t.nodes.resize(2);
  for (Node& node : t.nodes) node.T_map_vehicle = any_pose(Motion::kSpatial, draws);
  EXPECT_EQ(pose_at(t, 0, 0.0).translation_m, t.nodes[0].T_map_vehicle.translation_m);
  const Pose end = pose_at(t, 0, 1.0);
  EXPECT_LT((end.translation_m - t.nodes[1].T_map_vehicle.translation_m).norm(), 1e-14);
  EXPECT_LT(end.rotation.angularDistance(t.nodes[1].T_map_vehicle.rotation), 1e-7);
  t.nodes.resize(1);  // the last state has no next
  EXPECT_EQ(pose_at(t, 0, 0.0).translation_m, t.nodes[0].T_map_vehicle.translation_m);
}

// --- The motion prior ----------------------------------------------------------------------------------

/// Two states with velocities, a prior step between them.
Trajectory moving_pair(Random& draws, double step_s) {
  Trajectory t;
  t.motion_prior = MotionPrior{};
  t.nodes.resize(2);
  for (Node& node : t.nodes) {
    node.T_map_vehicle = any_pose(Motion::kPlanar, draws);
    node.velocity = draws.normal3();
  }
  t.motion_steps = {{0, step_s}};
  return t;
}

Eigen::VectorXd motion_residuals(const Trajectory& t) {
  ObservationRow rows[6];
  const int count = motion_rows(t, 0, rows);
  Eigen::VectorXd r(count);
  for (int i = 0; i < count; ++i) r[i] = rows[i].residual;
  return r;
}

Trajectory moved(Trajectory t, const Eigen::VectorXd& d) {
  for (const int k : {0, 1}) {
    Node& node = t.nodes[static_cast<std::size_t>(k)];
    node.T_map_vehicle = retract(node.T_map_vehicle, d.segment<3>(6 * k), Motion::kPlanar);
    node.velocity += d.segment<3>(6 * k + 3);
  }
  return t;
}

RC_GTEST_PROP(MotionRows, AgreeWithNumericDerivatives, ()) {
  Random draws = any_draws();
  const Trajectory t = moving_pair(draws, draws.uniform(0.05, 2.0));
  ObservationRow rows[6];
  const int count = motion_rows(t, 0, rows);
  RC_ASSERT(count == 6);
  // The difference of headings is wrapped, and leaps at half a turn.
  const double turn_rad =
      wrap_angle(t.nodes[1].T_map_vehicle.heading_rad() - t.nodes[0].T_map_vehicle.heading_rad());
  RC_PRE(std::abs(turn_rad) < M_PI - 1e-3);
  const Eigen::MatrixXd numeric =
      numeric_jacobian([&](const Eigen::VectorXd& d) { return motion_residuals(moved(t, d)); },
                       Eigen::VectorXd::Zero(12), 1e-6);
  Eigen::MatrixXd analytic(count, 12);
  for (int i = 0; i < count; ++i) {
    analytic.row(i).head<6>() = rows[i].by_node;
    analytic.row(i).tail<6>() =
        rows[i].has_next ? Eigen::RowVectorXd(rows[i].by_next) : Eigen::RowVectorXd::Zero(6);
  }
  // Residuals of up to thousands of sigmas at wrong states: their rounding errors divided by the step.
  const double scale = std::max(1.0, motion_residuals(t).cwiseAbs().maxCoeff() * 1e-3);
  RC_ASSERT((analytic - numeric).cwiseAbs().maxCoeff() < 1e-5 * scale * (1 + analytic.cwiseAbs().maxCoeff()));
}

// White-noise acceleration: a state propagated by its velocity costs zero for any step.
TEST(MotionRows, OfUniformMotionCostNothing) {
  Random draws(5);
  for (const double step_s : {0.02, 0.5, 3.0}) {
    Trajectory t = moving_pair(draws, step_s);
    t.nodes[0].velocity.z() = 0.8;  // short of half a turn in the longest step
    t.nodes[1] = t.nodes[0];
    const Pose& T = t.nodes[0].T_map_vehicle;
    const Eigen::Vector3d& v = t.nodes[0].velocity;
    t.nodes[1].T_map_vehicle =
        Pose::planar(T.translation_m.x() + step_s * v.x(), T.translation_m.y() + step_s * v.y(),
                     T.heading_rad() + step_s * v.z());
    EXPECT_LT(motion_residuals(t).norm(), 1e-9) << step_s;
  }
}

// Noise of acceleration with density q over a step has the covariance q (dt^3/3, dt^2/2; dt^2/2, dt) for
// position and velocity. Halving a step twice gives an equal prior.
TEST(MotionRows, DoNotDependOnHowAStepIsCut) {
  Random draws(6);
  const auto information = [](const Trajectory& t, std::size_t states) {
    const auto n = static_cast<Eigen::Index>(6 * states);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t i = 0; i < t.motion_steps.size(); ++i) {
      ObservationRow rows[6];
      const int count = motion_rows(t, i, rows);
      for (int r = 0; r < count; ++r) {
        Eigen::VectorXd a = Eigen::VectorXd::Zero(n);
        const auto at = static_cast<Eigen::Index>(6 * rows[r].node);
        a.segment<6>(at) = rows[r].by_node.transpose();
        if (rows[r].has_next) a.segment<6>(at + 6) = rows[r].by_next.transpose();
        H += a * a.transpose();
      }
    }
    return H;
  };
  Trajectory whole = moving_pair(draws, 1.0), halves = whole;
  halves.nodes.insert(halves.nodes.begin() + 1, halves.nodes[0]);
  halves.motion_steps = {{0, 0.5}, {1, 0.5}};
  const Eigen::MatrixXd H = information(whole, 2), h = information(halves, 3);
  std::vector<int> ends;
  for (int i = 0; i < 6; ++i) ends.push_back(i);
  for (int i = 12; i < 18; ++i) ends.push_back(i);
  const Eigen::MatrixXd inner = h.block<6, 6>(6, 6);
  const Eigen::MatrixXd left =
      h(ends, ends) - h(ends, Eigen::seqN(6, 6)) * inner.fullPivLu().solve(h(Eigen::seqN(6, 6), ends));
  EXPECT_LT((left - H).cwiseAbs().maxCoeff(), 1e-9 * H.cwiseAbs().maxCoeff());
}

TEST(MotionRows, OfAVelocityAloneHoldItAboutNothing) {
  Random draws(7);
  Trajectory t = moving_pair(draws, 0.0);
  t.motion_prior = MotionPrior{.speed_mps = 2.0, .turn_rate_rad_per_s = 0.5};
  ObservationRow rows[6];
  ASSERT_EQ(motion_rows(t, 0, rows), 4);
  EXPECT_EQ(rows[0].residual, 0.0) << "no heading is preferred";
  const Eigen::Vector3d v = t.nodes[0].velocity, sigma(2.0, 2.0, 0.5);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(std::abs(rows[i + 1].residual), std::abs(v[i]) / sigma[i], 1e-12);
    EXPECT_FALSE(rows[i + 1].has_next);
  }
}

// --- All rows of a chain together ----------------------------------------------------------------------

TEST(ChainSystem, IsTheSumOfItsRows) {
  Random draws(8);
  const RobustLoss loss{2.0, 3.0};
  OneArrival one(Motion::kSpatial, true, false, false, draws);
  for (int i = 0; i < 5; ++i) {
    one.t.arrivals.push_back(one.t.arrivals[0]);
    one.t.arrivals.back().tof_s += 2e-5 * i;
    one.t.arrivals.back().alpha = 0.15 * i;
  }
  one.t.arrivals[3].rejection = Rejection::kLate;
  one.t.poses.push_back({.node = 1, .T_map_vehicle = any_pose(Motion::kSpatial, draws)});
  one.t.odometry.push_back({.node = 0, .T_before_after = any_pose(Motion::kSpatial, draws)});
  one.t.segments.push_back({.last_node = 2, .last_arrival = 6, .last_pose = 1, .last_odometry = 1});
  ChainSystem system;
  build_chain_system(one.t, one.t.segments[0], one.state, loss, system);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(14, 14);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(14);
  double cost = 0.0;
  for_each_row(one.t, one.t.segments[0], one.state, [&](const ObservationRow& row) {
    double rho = row.residual * row.residual, w = 1.0;
    if (is_robust(row.kind)) loss.evaluate(row.residual, rho, w);
    Eigen::VectorXd a = Eigen::VectorXd::Zero(14);
    a.segment<7>(static_cast<Eigen::Index>(7 * row.node)) = row.by_node.transpose();
    if (row.has_next) a.segment<7>(7) += row.by_next.transpose();
    H += w * a * a.transpose();
    g += w * row.residual * a;
    cost += 0.5 * rho;
  });
  const double scale = 1e-13 * H.cwiseAbs().maxCoeff();
  EXPECT_LT((system.D[0] - H.topLeftCorner<7, 7>()).cwiseAbs().maxCoeff(), scale);
  EXPECT_LT((system.D[1] - H.bottomRightCorner<7, 7>()).cwiseAbs().maxCoeff(), scale);
  EXPECT_LT((system.U[0] - H.topRightCorner<7, 7>()).cwiseAbs().maxCoeff(), scale);
  EXPECT_LT((system.g[0] - g.head<7>()).cwiseAbs().maxCoeff(), 1e-12 * g.cwiseAbs().maxCoeff());
  EXPECT_LT((system.g[1] - g.tail<7>()).cwiseAbs().maxCoeff(), 1e-12 * g.cwiseAbs().maxCoeff());
  EXPECT_NEAR(system.cost, cost, 1e-12 * cost);
  EXPECT_NEAR(chain_cost(one.t, one.t.segments[0], one.state, loss), cost, 1e-12 * cost);
}

}  // namespace linearise_test
}  // namespace octant::test
