// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Columns, units and priors of the shared unknowns, each against the site's own numbers.
#include "calib/problem/parameters.h"

#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "models/physics/medium.h"
#include "models/simulator/random.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace parameters_test {

/// A site with this number of runs on which every kind of parameter is free, except whole arrays.
calib::Problem rich_problem(std::size_t runs = 2) {
  Scenario s = hall_scenario();
  add_attenuation(s);
  s.site.attenuation->half_power_angle_rad = {0.9, 0.1};
  s.site.timing.delay_per = {.beacon = true, .receiver = true, .site = true};
  s.site.timing.clock = Clock::kCycleOffset;
  s.site.timing.drift = 2e-6;
  s.site.timing.drift_sigma = 1e-6;
  s.site.noise.pair_sigma_s = 3e-6;
  s.site.speed_offset_per_run = true;
  for (SiteBeacon& b : s.site.beacons) b.log_gain = {0.1, 0.2};
  calib::Problem problem;
  problem.site = s.site;
  problem.runs.resize(runs);
  return problem;
}

calib::ParameterLayout layout_of(const calib::Problem& problem) {
  return calib::make_layout(problem, prior_state(problem.site));
}

/// All numbers that a state holds, one behind the other.
std::vector<double> numbers_of(const SharedState& s) {
  std::vector<double> out;
  for (const auto& p : s.beacon_p_map_m) out.insert(out.end(), p.data(), p.data() + 3);
  out.insert(out.end(), s.beacon_delay_s.begin(), s.beacon_delay_s.end());
  for (const auto& p : s.receiver_p_vehicle_m) out.insert(out.end(), p.data(), p.data() + 3);
  out.insert(out.end(), s.receiver_delay_s.begin(), s.receiver_delay_s.end());
  out.push_back(s.site_delay_s);
  out.insert(out.end(), s.speed_offset_mps.begin(), s.speed_offset_mps.end());
  if (s.attenuation)
    for (const double v : {s.attenuation->amplitude_1m_v, s.attenuation->absorption_np_per_m,
                           s.attenuation->rise_time_s, s.attenuation->half_power_angle_rad})
      out.push_back(v);
  out.insert(out.end(), s.pair_bias_s.begin(), s.pair_bias_s.end());
  out.insert(out.end(), s.beacon_log_gain.begin(), s.beacon_log_gain.end());
  out.insert(out.end(), s.clock_drift.begin(), s.clock_drift.end());
  return out;
}

TEST(Parameters, OfEveryKindHaveAColumnOfTheirOwn) {
  const calib::ParameterLayout layout = layout_of(rich_problem());
  // Five beacons that are no control points, eight delays of beacons and of receivers and one of the site,
  // two speeds, eight receivers, one drift, four of the attenuation, eight gains, all pairs.
  ASSERT_EQ(layout.size(), 15 + 8 + 8 + 1 + 2 + 24 + 1 + 4 + 8 + 64);
  std::set<ParameterKind> kinds;
  for (int c = 0; c < layout.size(); ++c) {
    const ParameterId& id = layout.parameters[static_cast<std::size_t>(c)].id;
    EXPECT_EQ(layout.column_of(id), c);
    kinds.insert(id.kind);
  }
  EXPECT_EQ(kinds.size(), kParameterKinds - 1) << "all but an array as a whole";
}

TEST(Parameters, MoveOneNumberOfTheStateEach) {
  const calib::ParameterLayout layout = layout_of(rich_problem());
  const Eigen::VectorXd x = layout.vector_of(layout.fixed);
  const std::vector<double> before = numbers_of(layout.state_of(x));
  std::set<std::size_t> moved;
  for (int c = 0; c < layout.size(); ++c) {
    const calib::Parameter& p = layout.parameters[static_cast<std::size_t>(c)];
    const double step = 0.25;
    const std::vector<double> after =
        numbers_of(layout.state_of(x + step * Eigen::VectorXd::Unit(x.size(), c)));
    ASSERT_EQ(before.size(), after.size());
    std::size_t changes = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (before[i] == after[i]) continue;
      ++changes;
      EXPECT_TRUE(moved.insert(i).second) << "two columns move number " << i;
      // One rounding of the sum, in the larger of both.
      EXPECT_NEAR(after[i] - before[i], step * p.si_per_unit, 1e-15 * std::max(1.0, std::abs(after[i]))) << c;
    }
    EXPECT_EQ(changes, 1U) << c;
  }
}

TEST(Parameters, CarryThePriorsOfTheSiteInSiUnits) {
  const calib::Problem problem = rich_problem();
  const Site& site = problem.site;
  const calib::ParameterLayout layout = layout_of(problem);
  const auto expect = [&](const ParameterId& id, double mean, double sigma) {
    const int c = layout.column_of(id);
    ASSERT_GE(c, 0);
    const calib::Parameter& p = layout.parameters[static_cast<std::size_t>(c)];
    EXPECT_NEAR(p.prior_mean * p.si_per_unit, mean, 1e-15 * std::max(1e-9, std::abs(mean)) + 1e-18);
    EXPECT_NEAR(p.prior_sigma * p.si_per_unit, sigma, 1e-14 * sigma);
  };
  expect(parameters::beacon_position(1, 2), *site.beacons[1].position_m[2], 0.3);
  expect(parameters::beacon_delay(4), 1e-4, 5e-5);
  expect(parameters::receiver_delay(3), 0.0, 5e-5);  // the mean stands once, on the beacons
  expect(parameters::site_delay(), 0.0, 5e-5);
  expect(parameters::speed(2), 0.0, 2.0);
  expect(parameters::receiver_position(5, 0), site.receivers[5].position_m.x(), 0.001);
  expect(parameters::clock_drift(0), 2e-6, 1e-6);
  expect(parameters::attenuation(0), 12.5, 1.25);
  expect(parameters::attenuation(1), 0.12, 0.02);
  expect(parameters::attenuation(2), 4.5e-4, 1e-4);
  expect(parameters::attenuation(3), 0.9, 0.1);
  expect(parameters::beacon_gain(7), 0.1, 0.2);
  expect(parameters::pair_bias(2, 6), 0.0, 3e-6);
}

// A unit of every number that is a time is a metre of the signal's way; so is the speed's at one metre.
TEST(Parameters, AreMetresOrPureNumbersInside) {
  for (const double factor : {1.0, 1e6}) {  // sound, and something like radio
    calib::Problem problem = rich_problem();
    problem.site.medium.model = MediumModel::kConstant;
    problem.site.medium.speed_mps = 343.0 * factor;
    const double c = speed_mps(problem.site.medium);
    const calib::ParameterLayout layout = layout_of(problem);
    for (const calib::Parameter& p : layout.parameters) {
      const double want =
          p.id.kind == ParameterKind::kSpeed ? c
          : p.id.kind == ParameterKind::kBeaconDelay || p.id.kind == ParameterKind::kSiteDelay ||
                  p.id.kind == ParameterKind::kReceiverDelay || p.id.kind == ParameterKind::kPairBias ||
                  p.id.kind == ParameterKind::kClockDrift
              ? 1 / c
          : p.id == parameters::attenuation(0) ? 12.5
          : p.id == parameters::attenuation(2) ? 1 / c
                                               : 1.0;
      EXPECT_DOUBLE_EQ(p.si_per_unit, want);
    }
  }
}

TEST(Parameters, OfHeldBeaconsAreNone) {
  const calib::Problem problem = rich_problem();
  std::vector<bool> usable(8, true);
  usable[4] = false;
  SharedState state = prior_state(problem.site);
  state.beacon_p_map_m[4] = {1.0, 2.0, 3.0};
  state.beacon_delay_s[4] = 7e-5;
  const calib::ParameterLayout layout = calib::make_layout(problem, state, usable);
  for (const calib::Parameter& p : layout.parameters)
    EXPECT_NE(beacon_of(p.id), std::optional<std::size_t>(4));
  for (std::size_t r = 0; r < 8; ++r) EXPECT_EQ(layout.column_of(parameters::pair_bias(4, r)), -1);
  EXPECT_EQ(layout.column_of(parameters::beacon_position(4, 0)), -1);
  const SharedState there = layout.state_of(Eigen::VectorXd::Constant(layout.size(), 1.5));
  EXPECT_EQ(there.beacon_p_map_m[4], Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(there.beacon_delay_s[4], 7e-5);
}

TEST(Parameters, OfCoordinatesWithoutASigmaHaveNoPrior) {
  calib::Problem problem = rich_problem();
  SiteBeacon& b = problem.site.beacons[1];
  b.position_m[0].reset();  // unknown
  b.sigma_m[0] = 0.3;
  b.sigma_m[1].reset();  // known, nobody says how well
  b.sigma_m[2] = 0.0;    // held
  const calib::ParameterLayout layout = layout_of(problem);
  EXPECT_EQ(layout.beacon[1][2], -1);
  for (const std::size_t axis : {0U, 1U}) {
    const int c = layout.beacon[1][axis];
    ASSERT_GE(c, 0);
    EXPECT_TRUE(std::isinf(layout.parameters[static_cast<std::size_t>(c)].prior_sigma));
  }
}

TEST(Parameters, SpeedIsOneForAllUnlessEachRunHasItsOwn) {
  calib::Problem problem = rich_problem(3);
  calib::ParameterLayout layout = layout_of(problem);
  ASSERT_EQ(layout.speed.size(), 3U);
  for (std::size_t run = 0; run < 3; ++run) EXPECT_EQ(layout.speed_column(run), layout.speed[run]);
  Eigen::VectorXd x = layout.vector_of(prior_state(problem.site));
  x[layout.speed_column(1)] = 0.01;
  const SharedState state = layout.state_of(x);
  EXPECT_NEAR(state.speed_offset(1), 0.01 * layout.nominal_speed_mps, 1e-12);
  EXPECT_EQ(state.speed_offset(0), 0.0);
  EXPECT_EQ(state.speed_offset(2), 0.0);

  problem.site.speed_offset_per_run = false;
  layout = layout_of(problem);
  ASSERT_EQ(layout.speed.size(), 1U);
  EXPECT_EQ(layout.speed_column(2), layout.speed[0]);
  problem.site.speed_sigma_mps = 0.0;
  EXPECT_EQ(layout_of(problem).speed_column(0), -1);
}

TEST(Parameters, BlocksCoverAllColumnsInTheirOrder) {
  const calib::ParameterLayout layout = layout_of(rich_problem());
  int next = 0;
  for (const calib::ParameterBlock& block : layout.blocks) {
    EXPECT_EQ(block.first, next);
    EXPECT_GT(block.size, 0);
    // Parameters that belong together have one owner.
    for (int i = 1; i < block.size; ++i) {
      const ParameterId &a = layout.parameters[static_cast<std::size_t>(block.first)].id,
                        &b = layout.parameters[static_cast<std::size_t>(block.first + i)].id;
      EXPECT_EQ(a.kind, b.kind);
      EXPECT_EQ(a.owner, b.owner);
    }
    next += block.size;
  }
  EXPECT_EQ(next, layout.size());
}

TEST(Parameters, DenseUpToTheLimit) {
  calib::ParameterLayout layout = layout_of(rich_problem());
  layout.dense_limit = layout.size();
  EXPECT_TRUE(is_dense(layout));
  layout.dense_limit = layout.size() - 1;
  EXPECT_FALSE(is_dense(layout));
}

/// The octagon of the hall, turned by `turn_rad` and adjusted as a whole.
calib::Problem array_problem(double turn_rad) {
  calib::Problem problem;
  problem.site = hall_scenario().site;
  problem.runs.resize(1);
  problem.site.vehicles[0].array = ArrayShape{.radius_sigma_m = 0.002, .turn_sigma_rad = 0.05};
  for (SiteReceiver& r : problem.site.receivers)
    r.position_m.head<2>() = Eigen::Rotation2Dd(turn_rad) * Eigen::Vector2d(r.position_m.head<2>());
  return problem;
}

TEST(Parameters, OfAnArrayTurnAndWidenItsReceiversTogether) {
  for (const double turn_rad : {0.0, 1.0, 3.1, -2.5}) {
    SCOPED_TRACE(turn_rad);
    const calib::Problem problem = array_problem(turn_rad);
    const calib::ParameterLayout layout = layout_of(problem);
    EXPECT_EQ(layout.column_of(parameters::receiver_position(0, 0)), -1) << "none of them by itself";
    const int radius = layout.column_of(parameters::array_radius(0)),
              turn = layout.column_of(parameters::array_turn(0));
    ASSERT_GE(std::min(radius, turn), 0);
    const double radius_m = problem.site.receivers[0].position_m.head<2>().norm();
    Eigen::VectorXd x = layout.vector_of(layout.fixed);
    EXPECT_NEAR(x[radius], radius_m, 1e-15);
    x[radius] *= 1.1;
    x[turn] += 0.2 * radius_m;  // in metres of arc
    const SharedState state = layout.state_of(x);
    for (std::size_t r = 0; r < 8; ++r) {
      const Eigen::Vector3d was = problem.site.receivers[r].position_m;
      const Eigen::Vector3d want = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()) *
                                   Eigen::Vector3d(1.1 * was.x(), 1.1 * was.y(), was.z());
      EXPECT_LT((state.receiver_p_vehicle_m[r] - want).norm(), 1e-14) << r;  // roundings of some decimetres
    }
    EXPECT_LT((layout.vector_of(state) - x).norm(), 1e-14);
  }
}

// The first corner may be where its direction wraps from pi to -pi.
TEST(Parameters, OfAnArrayStayNearTheirPriorAcrossTheHalfTurn) {
  calib::Problem problem = array_problem(0.0);
  const Eigen::Vector3d corner = problem.site.receivers[0].position_m;
  problem = array_problem(M_PI - 0.01 - std::atan2(corner.y(), corner.x()));
  const calib::ParameterLayout layout = layout_of(problem);
  SharedState turned = layout.fixed;
  for (Eigen::Vector3d& p : turned.receiver_p_vehicle_m)
    p = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()) * p;
  const int turn = layout.column_of(parameters::array_turn(0));
  const calib::Parameter& p = layout.parameters[static_cast<std::size_t>(turn)];
  EXPECT_NEAR((layout.vector_of(turned)[turn] - p.prior_mean) * p.si_per_unit, 0.02, 1e-13);
}

/// Positive definite, its columns of sizes between a micrometre and a kilometre.
Eigen::MatrixXd any_covariance(Eigen::Index n, Random& draws) {
  Eigen::MatrixXd A(n, n);
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = draws.normal();
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = std::pow(10.0, draws.uniform(-6, 3));
  return scale.asDiagonal() * (A * A.transpose() + Eigen::MatrixXd::Identity(n, n)) * scale.asDiagonal();
}

RC_GTEST_PROP(JointPrior, SquaresAreTheMahalanobisDistance, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const int n = *rc::gen::inRange(1, 8);
  const Eigen::MatrixXd C = any_covariance(n, draws);
  std::vector<int> columns;
  for (int i = 0; i < n; ++i) columns.push_back(2 * i + 1);  // every second of the vector
  Eigen::VectorXd x(2 * n + 1), mean(n), off(n);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = draws.normal();
  for (Eigen::Index i = 0; i < n; ++i) {
    mean[i] = x[2 * i + 1] - std::sqrt(C(i, i)) * draws.normal();
    off[i] = x[2 * i + 1] - mean[i];
  }
  const calib::JointPrior prior = calib::joint_prior(columns, mean, C);
  // Orthogonal factors, not the Cholesky ones that are tested; both lose digits as the scaled matrix does,
  // whose condition is below some 1e5.
  const Eigen::VectorXd scale = C.diagonal().cwiseSqrt();
  const Eigen::MatrixXd R = scale.cwiseInverse().asDiagonal() * C * scale.cwiseInverse().asDiagonal();
  const Eigen::VectorXd u = off.cwiseQuotient(scale);
  const double want = u.dot(R.fullPivHouseholderQr().solve(u));
  RC_ASSERT(std::abs(prior.residual(x).squaredNorm() - want) <= 1e-9 * std::max(want, u.squaredNorm()));
  const Eigen::MatrixXd left =
      scale.asDiagonal() * prior.root.transpose() * prior.root * scale.asDiagonal() * R;
  RC_ASSERT((left - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff() < 1e-9);
}

}  // namespace parameters_test
}  // namespace octant::test
