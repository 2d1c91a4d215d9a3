// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/make_trajectory.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "models/trajectory/linearise.h"
#include "tests/support/numeric.h"

namespace octant {
namespace trajectory_test {

/// A drive of five nodes among three beacons with every kind of observation, noisy, in planar or spatial
/// motion.
struct Drive {
  Trajectory t;
  SharedState state;

  explicit Drive(Motion motion, bool cycle_offset = false) {
    std::mt19937 random(5);
    std::normal_distribution<double> n;
    t.motion = motion;
    t.has_cycle_offset = cycle_offset;
    for (int b = 0; b < 3; ++b) {
      state.beacon_p_map_m.push_back({4.0 * b, 3.0 + n(random), 2.0 + 0.2 * b});
      state.beacon_delay_s.push_back(1e-4);
    }
    state.receiver_p_vehicle_m = {{0.2, 0.05, 0.3}, {-0.2, 0.1, 0.35}};
    state.receiver_delay_s = {0.0, 1e-5};
    state.attenuation = AttenuationModel{12.5, 0.1, 0.05, 4e-4};
    for (int k = 0; k < 5; ++k) {
      Node node;
      node.time_s = k;
      node.placed = true;
      node.T_map_vehicle = Pose::planar(k, 0.1 * k * k, 0.2 * k);
      if (motion == Motion::kSpatial)
        node.T_map_vehicle.rotation = exp_rotation({0.1 * n(random), 0.1 * n(random), 0.2 * k});
      t.nodes.push_back(node);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      t.odometry.push_back(
          {k, t.nodes[k].T_map_vehicle.inverse() * t.nodes[k + 1].T_map_vehicle, 0.02, 0.01});
      for (int i = 0; i < 6; ++i) {
        ArrivalObservation a;
        a.node = k;
        a.alpha = 0.15 * i;
        a.beacon = BeaconId(i % 3);
        a.receiver = ReceiverId(i % 2);
        a.sigma_s = 1e-5;
        a.model_speed_mps = 343.0;
        a.tof_s = 0.01 + 1e-3 * i;
        a.log_amplitude = 0.4;
        a.log_amplitude_sigma = 0.05;
        a.arrival = t.arrivals.size();
        t.arrivals.push_back(a);
      }
      if (motion == Motion::kPlanar)
        t.bearings.push_back(
            {k, 0.5, k, BeaconId(static_cast<std::int32_t>(k % 3)), 0.7, 0.01, Rejection::kUsed});
      t.poses.push_back({k, 0.25, t.nodes[k].T_map_vehicle, 0.01, 0.02, 0.03});
    }
    t.segments.push_back(
        {0, 5, 0, t.arrivals.size(), 0, t.bearings.size(), 0, t.poses.size(), 0, t.odometry.size()});
  }

  void move(const Eigen::VectorXd& x) {
    const int n = t.block_size(), dof = pose_dof(t.motion);
    for (std::size_t k = 0; k < t.nodes.size(); ++k) {
      const Eigen::VectorXd part = x.segment(static_cast<Eigen::Index>(k) * n, n);
      t.nodes[k].T_map_vehicle = retract(t.nodes[k].T_map_vehicle, part.head(dof), t.motion);
      if (t.has_cycle_offset) t.nodes[k].cycle_offset_s += part[dof] / t.nominal_speed_mps;
    }
  }
};

class Rows : public testing::TestWithParam<Motion> {};

TEST_P(Rows, DerivativesByStatesAgreeWithNumericOnes) {
  const Drive drive(GetParam(), true);
  const int n = drive.t.block_size();
  const auto unknowns = static_cast<Eigen::Index>(drive.t.nodes.size()) * n;
  Eigen::MatrixXd J;
  const auto residuals = [&](const Eigen::VectorXd& x, bool fill) {
    Drive moved = drive;
    moved.move(x);
    std::vector<double> r;
    std::vector<Eigen::RowVectorXd> rows;
    for_each_row(moved.t, moved.t.segments[0], moved.state, [&](const ObservationRow& row) {
      r.push_back(row.residual);
      Eigen::RowVectorXd full = Eigen::RowVectorXd::Zero(unknowns);
      full.segment(static_cast<Eigen::Index>(row.node) * n, n) += row.by_node;
      if (row.has_next) full.segment(static_cast<Eigen::Index>(row.node + 1) * n, n) += row.by_next;
      rows.push_back(full);
    });
    if (fill) {
      J.resize(static_cast<Eigen::Index>(rows.size()), unknowns);
      for (std::size_t i = 0; i < rows.size(); ++i) J.row(static_cast<Eigen::Index>(i)) = rows[i];
    }
    return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size())));
  };
  // Away from the point at which odometry and poses fit exactly.
  Eigen::VectorXd at(unknowns);
  for (Eigen::Index i = 0; i < unknowns; ++i) at[i] = 0.05 * std::sin(3.0 * static_cast<double>(i));
  residuals(at, true);
  const Eigen::MatrixXd analytic = J;
  const Eigen::MatrixXd numeric = test::numeric_jacobian(
      [&](const Eigen::VectorXd& d) {
        Drive moved = drive;
        moved.move(at);
        Drive again = moved;
        again.move(d);
        std::vector<double> r;
        for_each_row(again.t, again.t.segments[0], again.state,
                     [&](const ObservationRow& row) { r.push_back(row.residual); });
        return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size())));
      },
      Eigen::VectorXd::Zero(unknowns), 1e-6);
  ASSERT_EQ(analytic.rows(), numeric.rows());
  // Rows are whitened: derivatives of up to 300 a metre; central differences lose half the digits.
  EXPECT_LT((analytic - numeric).cwiseAbs().maxCoeff(), 2e-5 * analytic.cwiseAbs().maxCoeff());
}

TEST_P(Rows, SolveStatesFindsTheLeastSquaresStates) {
  Drive drive(GetParam());
  const StateSolveResult result = solve_states(drive.t, drive.t.segments[0], drive.state, {}, 100);
  EXPECT_TRUE(result.converged);
  ChainSystem system;
  build_chain_system(drive.t, drive.t.segments[0], drive.state, {}, system);
  for (std::size_t k = 0; k < system.g.size(); ++k)
    EXPECT_LT(system.g[k].norm(), 1e-3 * std::sqrt(system.D[k].trace()))
        << "gradient left at node " << k;  // in sigmas
}

TEST_P(Rows, NodeCovarianceIsTheBlockOfTheDenseInverse) {
  Drive drive(GetParam());
  solve_states(drive.t, drive.t.segments[0], drive.state, {}, 100);
  ChainSystem system;
  build_chain_system(drive.t, drive.t.segments[0], drive.state, {}, system);
  const Eigen::Index n = drive.t.block_size(), K = 5;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n * K, n * K);
  for (Eigen::Index k = 0; k < K; ++k) {
    H.block(k * n, k * n, n, n) = system.D[static_cast<std::size_t>(k)];
    if (k + 1 < K) {
      H.block(k * n, (k + 1) * n, n, n) = system.U[static_cast<std::size_t>(k)];
      H.block((k + 1) * n, k * n, n, n) = system.U[static_cast<std::size_t>(k)].transpose();
    }
  }
  const Eigen::MatrixXd C = H.inverse();
  for (std::size_t k = 0; k < 5; ++k) {
    const Eigen::MatrixXd got = node_covariance(drive.t, drive.t.segments[0], k, drive.state);
    const Eigen::MatrixXd want =
        C.block(static_cast<Eigen::Index>(k) * n, static_cast<Eigen::Index>(k) * n, n, n);
    EXPECT_LT((got - want).norm(), 1e-8 * want.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, Rows, testing::Values(Motion::kPlanar, Motion::kSpatial));

TEST(RobustLoss, IsCauchyOnEitherSide) {
  double rho = 0, w = 0;
  RobustLoss{}.evaluate(3.0, rho, w);
  EXPECT_EQ(rho, 9.0);
  EXPECT_EQ(w, 1.0);
  const RobustLoss loss{2.0, 5.0};
  loss.evaluate(3.0, rho, w);
  EXPECT_DOUBLE_EQ(rho, 4 * std::log1p(9.0 / 4));
  EXPECT_DOUBLE_EQ(w, 1 / (1 + 9.0 / 4));
  loss.evaluate(-3.0, rho, w);
  EXPECT_DOUBLE_EQ(w, 1 / (1 + 9.0 / 25));
}

TEST(MakeTrajectory, EpochsAreSegmentsWithTheirOwnArrivals) {
  MeasurementLog log;
  log.has_epochs = true;
  for (int i = 0; i < 9; ++i) {
    Arrival a;
    a.time_s = i;
    a.tof_s = 0.01;
    a.beacon = BeaconId(i % 3);
    a.receiver = ReceiverId(0);
    a.vehicle = VehicleId(0);
    a.epoch = 10 + i / 3;
    log.arrivals.push_back(a);
  }
  const Trajectory t = make_trajectory(log, 0, VehicleId(0), {});
  ASSERT_EQ(t.segments.size(), 3u);
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(t.segments[s].last_arrival - t.segments[s].first_arrival, 3u);
    EXPECT_EQ(t.nodes[s].epoch, 10 + static_cast<int>(s));
    EXPECT_FALSE(t.nodes[s].placed);
  }
}

TEST(MakeTrajectory, ArrivalsOutsideTheOdometryAreStateless) {
  MeasurementLog log;
  for (int i = 0; i < 4; ++i) log.odometry.push_back({1.0 + i, i > 0 ? 0.5 : 0.0, 0.0, 0.0, VehicleId(0)});
  for (const double time_s : {0.5, 1.0, 2.25, 4.0, 4.5}) {
    Arrival a;
    a.time_s = time_s;
    a.tof_s = 0.01;
    a.beacon = BeaconId(0);
    a.receiver = ReceiverId(0);
    a.vehicle = VehicleId(0);
    log.arrivals.push_back(a);
  }
  const Trajectory t = make_trajectory(log, 0, VehicleId(0), {});
  EXPECT_EQ(t.stateless_arrivals, (std::vector<std::size_t>{0, 4}));
  ASSERT_EQ(t.arrivals.size(), 3u);
  EXPECT_EQ(t.arrivals[1].node, 1u);
  EXPECT_DOUBLE_EQ(t.arrivals[1].alpha, 0.25);
  EXPECT_EQ(t.arrivals[2].node, 2u);
  EXPECT_DOUBLE_EQ(t.arrivals[2].alpha, 1.0);
}

/// Three receivers receive a sound within 0.2 ms, a fourth one 5 ms later, the first one again after 50 ms;
/// the vehicle's pose is measured once a second.
MeasurementLog posed_log(double speed_mps, double turn_rate_rad_per_s = 0.0) {
  MeasurementLog log;
  log.vehicle = VehicleId(0);
  for (int k = 0; k < 3; ++k)
    log.poses.push_back({1.0 * k, Pose::planar(speed_mps * k, 0.0, turn_rate_rad_per_s * k)});
  const double times_s[] = {0.5, 0.5001, 0.5002, 0.505, 0.55};
  for (int i = 0; i < 5; ++i) {
    Arrival a;
    a.time_s = times_s[i];
    a.tof_s = 0.01;
    a.beacon = BeaconId(0);
    a.receiver = ReceiverId(i % 4);
    a.vehicle = VehicleId(0);
    log.arrivals.push_back(a);
  }
  return log;
}

/// Node of each arrival.
std::vector<std::size_t> states_of(const MeasurementLog& log) {
  TrajectoryModel model;
  model.noise.tof_sigma_s = 1e-5;  // 3.4 mm
  const Trajectory t = make_trajectory(log, 0, VehicleId(0), model);
  std::vector<std::size_t> states;
  for (const ArrivalObservation& a : t.arrivals) states.push_back(a.node);
  EXPECT_EQ(t.poses.size(), t.nodes.size());
  EXPECT_EQ(t.segments.size(), t.nodes.size());
  return states;
}

// A measured pose has one error, for any number of receivers.
TEST(MakeTrajectory, AMomentAtAMeasuredPoseIsOneState) {
  EXPECT_EQ(states_of(posed_log(0.0)), (std::vector<std::size_t>{0, 0, 0, 0, 1}));
  EXPECT_EQ(states_of(posed_log(1.0)), (std::vector<std::size_t>{0, 0, 0, 1, 2}));   // 5 mm in 5 ms
  EXPECT_EQ(states_of(posed_log(20.0)), (std::vector<std::size_t>{0, 1, 2, 3, 4}));  // 2 mm in 0.1 ms
  EXPECT_EQ(states_of(posed_log(0.0, 3.0)), (std::vector<std::size_t>{0, 0, 0, 1, 2}));
}

TEST(MakeTrajectory, WithoutMeasuredPosesEachInstantIsAState) {
  MeasurementLog log = posed_log(0.0);
  log.poses.clear();
  TrajectoryModel model;
  model.motion = Motion::kSpatial;
  model.noise.tof_sigma_s = 1e-5;
  std::vector<std::size_t> states;
  for (const ArrivalObservation& a : make_trajectory(log, 0, VehicleId(0), model).arrivals)
    states.push_back(a.node);
  EXPECT_EQ(states, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
}

TEST(InterpolatePoses, NeverBeyondTheEndsNorOverLongGaps) {
  const std::vector<TimedPose> poses = {
      {0.0, Pose::planar(0, 0, 0)}, {1.0, Pose::planar(2, 0, 1.0)}, {5.0, Pose::planar(2, 4, 1.0)}};
  Pose T;
  EXPECT_FALSE(interpolate_poses(poses, -0.1, 2.0, T));
  EXPECT_FALSE(interpolate_poses(poses, 5.1, 2.0, T));
  EXPECT_FALSE(interpolate_poses(poses, 3.0, 2.0, T));
  ASSERT_TRUE(interpolate_poses(poses, 0.25, 2.0, T));
  EXPECT_NEAR(T.translation_m.x(), 0.5, 1e-15);
  EXPECT_NEAR(T.heading_rad(), 0.25, 1e-12);
  EXPECT_TRUE(interpolate_poses(poses, 5.0, 0.1, T));
}

/// Noise of the walk from a measured amplitude: for a directional receiver a part of the noise, and more of
/// it for weaker pulses.
TEST(Observe, AWeakPulseOfADirectionalReceiverIsKnownLessWell) {
  TrajectoryModel model;
  model.noise.tof_sigma_s = 1e-5;
  model.noise.amplitude_relative_sigma = 0.05;
  const auto observed = [&](double amplitude_v) {
    Arrival a{.tof_s = 0.01, .beacon = BeaconId(0), .receiver = ReceiverId(0), .vehicle = VehicleId(0)};
    a.amplitude_v = amplitude_v;
    return observe(a, model, 343.0);
  };
  EXPECT_EQ(observed(1.0).log_amplitude_sigma, 0.0) << "no model of amplitudes";
  model.attenuation = AttenuationModel{12.5, 0.1, 0.2, 4.5e-4};
  EXPECT_EQ(observed(1.0).log_amplitude_sigma, 0.05);
  EXPECT_EQ(observed(1.0).sigma_s, 1e-5) << "the walk is taken at the predicted amplitude";
  EXPECT_FALSE(walk_amplitude(observed(1.0), {.attenuation = model.attenuation}));
  model.attenuation->half_power_angle_rad = 0.4;
  EXPECT_NEAR(walk_amplitude(observed(1.0), {.attenuation = model.attenuation}).value(), 0.0, 1e-15);
  const double share = 0.2 / 0.95;  // a sigma weaker
  EXPECT_NEAR(observed(1.0).sigma_s, std::hypot(1e-5, 4.5e-4 * share / (1 - share) * 0.05), 1e-12);
  EXPECT_GT(observed(0.25).sigma_s, 5 * observed(1.0).sigma_s);
  model.attenuation->saturation_v = 4.7;
  EXPECT_EQ(observed(4.7).log_amplitude_sigma, 0.0) << "at its stop";
  EXPECT_EQ(observed(4.7).sigma_s, 1e-5);
}

}  // namespace trajectory_test
}  // namespace octant
