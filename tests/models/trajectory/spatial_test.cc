// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Compared with differences, and with the rows of linearise.h, which do not use these formulas.
#include "models/trajectory/spatial.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"
#include "models/trajectory/linearise.h"
#include "tests/support/numeric.h"

namespace octant::test {
namespace spatial_test {

using Vector6 = SpatialArrival::Vector6;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Two states with an arrival and an odometry row between them: the turn of the odometry row is arbitrary,
/// zero, or up to almost half a turn.
struct OneStep {
  Trajectory t;
  SharedState state;

  explicit OneStep(Random& draws) {
    t.motion = Motion::kSpatial;
    t.nodes.resize(2);
    t.nodes[0].T_map_vehicle = {5 * draws.normal3(), exp_rotation(draws.normal3())};
    Eigen::Vector3d turn = *rc::gen::element(0.0, 1e-9, 0.03, 0.2, 1.0) * draws.normal3();
    if (turn.norm() > 3.0) turn *= 3.0 / turn.norm();
    t.nodes[1].T_map_vehicle = t.nodes[0].T_map_vehicle * Pose{draws.normal3(), exp_rotation(turn)};
    state.beacon_p_map_m = {t.nodes[0].T_map_vehicle * Eigen::Vector3d(4, 2, 3)};
    state.beacon_delay_s = {1e-4};
    state.receiver_p_vehicle_m = {draws.normal3()};
    state.receiver_delay_s = {1e-5};
    state.speed_offset_mps = {1.5};
    ArrivalObservation a;
    a.beacon = BeaconId(0);
    a.receiver = ReceiverId(0);
    a.alpha = *rc::gen::element(0.0, 1.0, draws.uniform(0.0, 1.0));
    a.tof_s = 0.014;
    a.sigma_s = 2e-5;
    a.model_speed_mps = 343.0;
    t.arrivals = {a};
    const Pose off{0.1 * draws.normal3(), exp_rotation(*rc::gen::element(0.0, 1e-3, 0.3) * draws.normal3())};
    t.odometry = {{0, (t.nodes[0].T_map_vehicle.inverse() * t.nodes[1].T_map_vehicle) * off, 0.02, 0.03}};
  }
  [[nodiscard]] SpatialInterval interval() const {
    return {t.nodes[0].T_map_vehicle, t.nodes[1].T_map_vehicle};
  }
  [[nodiscard]] SpatialArrival arrival() const {
    ArrivalWhitening whitening(state.speed_offset(0));
    whitening.set(t.arrivals[0]);
    const SpatialInterval i = interval();
    return {t.arrivals[0], i, SpatialInstant(i, t.arrivals[0].alpha), state, whitening};
  }
};

Random any_draws() { return Random(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>())); }

RC_GTEST_PROP(SpatialArrivalRow, IsTheMeasurementEquationAndItsDerivative, ()) {
  Random draws = any_draws();
  const OneStep one(draws);
  const SpatialArrival row = one.arrival();
  // Times of flight of some 15 ms in units of 20 us, to rounding.
  RC_ASSERT(std::abs(row.residual - arrival_residual(one.t, one.t.arrivals[0], one.state)) < 1e-10);
  const auto residual = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    Trajectory moved = one.t;
    for (const int k : {0, 1}) {
      Pose& T = moved.nodes[static_cast<std::size_t>(k)].T_map_vehicle;
      T = retract(T, d.segment<6>(6 * k), Motion::kSpatial);
    }
    return Eigen::VectorXd::Constant(1, arrival_residual(moved, moved.arrivals[0], one.state));
  };
  Eigen::RowVectorXd by(12);
  by << row.by_node.transpose(), row.by_next.transpose();
  // Residuals change by 150 a metre: of their differences seven digits are left.
  RC_ASSERT((by - numeric_jacobian(residual, Eigen::VectorXd::Zero(12), 1e-5)).cwiseAbs().maxCoeff() < 2e-4);
}

RC_GTEST_PROP(SpatialArrivalRow, IsThatOfTheGeneralWay, ()) {
  Random draws = any_draws();
  const OneStep one(draws);
  const SpatialArrival row = one.arrival();
  ObservationRow general[2];
  RC_ASSERT(arrival_rows(one.t, 0, one.state, general) == 1);
  RC_ASSERT((row.by_node - general[0].by_node.transpose()).cwiseAbs().maxCoeff() < 1e-9);
  RC_ASSERT((row.by_next - general[0].by_next.transpose()).cwiseAbs().maxCoeff() < 1e-9);
  const SpatialInterval i = one.interval();
  const Eigen::Vector3d by_receiver =
      row.by_distance * SpatialInstant(i, one.t.arrivals[0].alpha).turned_back(i, row.direction_first);
  RC_ASSERT((by_receiver - general[0].by_receiver.transpose()).cwiseAbs().maxCoeff() < 1e-9);
  RC_ASSERT((row.by_distance * row.direction + general[0].by_beacon.transpose()).cwiseAbs().maxCoeff() <
            1e-9);
}

RC_GTEST_PROP(SpatialInstant, TurnsThereAndBack, ()) {
  Random draws = any_draws();
  const OneStep one(draws);
  const SpatialInterval i = one.interval();
  const double alpha = draws.uniform(0.0, 1.0);
  const SpatialInstant at(i, alpha);
  const Eigen::Vector3d v = draws.normal3();
  RC_ASSERT((i.R * at.turned(i, v) - pose_at(one.t, 0, alpha).rotation * v).norm() < 1e-13);
  RC_ASSERT((at.turned_back(i, at.turned(i, v)) - v).norm() < 1e-13);
}

RC_GTEST_PROP(SpatialStepOf, HasTheNormalEquationsOfItsRows, ()) {
  Random draws = any_draws();
  const OneStep one(draws);
  ObservationRow rows[6];
  RC_ASSERT(odometry_rows(one.t, 0, rows) == 6);
  Matrix6 D = Matrix6::Zero(), U = D, N = D;
  Vector6 g = Vector6::Zero(), g_next = g;
  double cost = 0.0;
  for (const ObservationRow& row : rows) {
    const Vector6 a = row.by_node.transpose(), b = row.by_next.transpose();
    D -= a * a.transpose();
    U -= a * b.transpose();
    N -= b * b.transpose();
    g -= row.residual * a;
    g_next -= row.residual * b;
    cost += 0.5 * row.residual * row.residual;
  }
  const double scale = -D.trace();
  const SpatialInterval i = one.interval();
  const SpatialStep step(one.t.odometry[0], i);
  step.add_to(D, g, U, N, g_next);
  RC_ASSERT(std::abs(step.cost() - cost) < 1e-11 * (1.0 + cost));
  for (const Matrix6& left : {D, U, N}) RC_ASSERT(left.cwiseAbs().maxCoeff() < 1e-12 * scale);
  for (const Vector6& left : {g, g_next})
    RC_ASSERT(left.cwiseAbs().maxCoeff() < 1e-11 * std::sqrt(scale) * (1.0 + std::sqrt(cost)));
}

TEST(HasSpatialArrivals, AsksForPlainPathsInSpace) {
  Trajectory t;
  t.arrivals.resize(1);
  const Segment all{0, 1, 0, 1};
  SharedState state;
  EXPECT_FALSE(has_spatial_arrivals(t, all, state));  // in the plane
  t.motion = Motion::kSpatial;
  EXPECT_TRUE(has_spatial_arrivals(t, all, state));
  t.arrivals[0].two_way = true;
  EXPECT_FALSE(has_spatial_arrivals(t, all, state));
  t.arrivals[0].two_way = false;
  t.has_cycle_offset = true;
  EXPECT_FALSE(has_spatial_arrivals(t, all, state));
  t.has_cycle_offset = false;
  state.attenuation = AttenuationModel{12.5, 0.1, 0.05, 4e-4};
  EXPECT_FALSE(has_spatial_arrivals(t, all, state));
}

}  // namespace spatial_test
}  // namespace octant::test
