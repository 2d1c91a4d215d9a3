// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/odometry_track.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"
#include "tests/support/numeric.h"

namespace octant::test {
namespace odometry_track_test {

std::vector<OdometryStep> any_steps(std::size_t count, Random& draws) {
  std::vector<OdometryStep> steps(count);
  for (std::size_t i = 0; i < count; ++i) {
    steps[i].time_s = 0.1 * static_cast<double>(i);
    steps[i].dx_m = 0.1 * draws.normal();
    steps[i].dy_m = 0.02 * draws.normal();
    steps[i].dheading_rad = 0.1 * draws.normal();
    steps[i].vehicle = VehicleId(0);
  }
  return steps;
}

RC_GTEST_PROP(AdvanceState, CarriesTheCovarianceByItsDerivative, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const OdometryStep step = any_steps(1, draws)[0];
  OdometryState state{.p_map_m = {draws.normal(), draws.normal()}, .heading_rad = draws.uniform(-3, 3)};
  Eigen::Matrix3d A;
  for (Eigen::Index i = 0; i < 9; ++i) A(i) = draws.normal();
  state.covariance = A * A.transpose();
  const double fraction = draws.uniform(0.1, 1.0);
  const auto moved = [&](const Eigen::VectorXd& off) -> Eigen::VectorXd {
    OdometryState s = state;
    s.p_map_m += off.head<2>();
    s.heading_rad += off[2];
    advance(s, step, {}, fraction);
    return Eigen::Vector3d(s.p_map_m.x(), s.p_map_m.y(), s.heading_rad);
  };
  RC_PRE(std::abs(std::abs(state.heading_rad + fraction * step.dheading_rad) - M_PI) > 1e-3);
  const Eigen::MatrixXd F = numeric_jacobian(moved, Eigen::Vector3d::Zero(), 1e-5);
  const OdometryAccuracy none{.distance_sigma_m_per_sqrt_m = 0.0,
                              .heading_sigma_rad_per_sqrt_m = 0.0,
                              .floor_m = 0.0,
                              .floor_rad = 0.0};
  OdometryState exact = state, noisy = state;
  advance(exact, step, none, fraction);
  const Eigen::Matrix3d want = F * state.covariance * F.transpose();
  RC_ASSERT((exact.covariance - want).cwiseAbs().maxCoeff() < 1e-8 * want.cwiseAbs().maxCoeff());
  // Noise: of a whole step by its length, turn and floor; of a part in proportion.
  const OdometryAccuracy accuracy{.distance_sigma_m_per_sqrt_m = 0.05,
                                  .heading_sigma_rad_per_sqrt_m = 0.03,
                                  .heading_sigma_per_rad = 0.2,
                                  .floor_m = 0.004,
                                  .floor_rad = 0.006};
  advance(noisy, step, accuracy, fraction);
  const double length_m = std::hypot(step.dx_m, step.dy_m);
  const Eigen::Matrix3d added = noisy.covariance - exact.covariance;
  const Eigen::Vector3d sigma2(0.0025 * length_m + 1.6e-5, 0.0025 * length_m + 1.6e-5,
                               0.0009 * length_m + std::pow(0.2 * step.dheading_rad, 2) + 3.6e-5);
  RC_ASSERT((added - Eigen::Matrix3d((fraction * sigma2).asDiagonal())).cwiseAbs().maxCoeff() <
            1e-13 * (1 + want.cwiseAbs().maxCoeff()));
}

RC_GTEST_PROP(OdometryCursor, GivesEachRowOnceHoweverTheWayIsCut, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const std::vector<OdometryStep> steps = any_steps(30, draws);
  const double from_s = draws.uniform(-0.5, 1.0);
  OdometryCursor cursor(steps, from_s);
  std::vector<double> share(steps.size(), 0.0);
  double time_s = from_s;
  while (time_s < 3.2) {
    time_s += draws.uniform(0.0, 0.35);
    cursor.advance_to(time_s, [&](const OdometryStep& step, double fraction) {
      RC_ASSERT(fraction > 0.0 && fraction <= 1.0 + 1e-12);
      share[static_cast<std::size_t>(&step - steps.data())] += fraction;
      RC_ASSERT(step.time_s - 0.1 <= time_s + 1e-12);  // no row that has not begun
    });
  }
  RC_ASSERT(share[0] == 0.0);  // the anchor is no motion
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const double left = std::clamp((steps[i].time_s - from_s) / 0.1, 0.0, 1.0);
    RC_ASSERT(std::abs(share[i] - left) < 1e-9);
  }
}

TEST(OdometryCursor, GivesNothingForAnInstantThatIsPast) {
  Random draws(3);
  const std::vector<OdometryStep> steps = any_steps(10, draws);
  OdometryCursor cursor(steps, 0.0);
  int calls = 0;
  const auto count = [&](const OdometryStep&, double) { ++calls; };
  cursor.advance_to(0.35, count);
  EXPECT_EQ(calls, 4);
  cursor.advance_to(0.2, count);
  EXPECT_EQ(calls, 4);
  OdometryCursor none({}, 0.0);
  none.advance_to(5.0, count);
  EXPECT_EQ(calls, 4);
}

}  // namespace odometry_track_test
}  // namespace octant::test
