// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/newton_steps.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/calib/stream/one_residual.h"

namespace octant::test {
namespace newton_steps_test {

calib::PassSum steps(OneResidual& readings, calib::Estimate& estimate,
                     std::optional<calib::PassSum> first = {}) {
  const calib::Problem frame;
  const calib::SolveOptions options;
  calib::ProgressMonitor monitor(options);
  return must(calib::newton_steps(readings, frame, options, monitor, std::move(first), estimate));
}

// With a prior: the minimum of 1/2 (2 x - 6)^2 + 1/2 ((x - 1) / 0.5)^2 is where 8 x = 16.
TEST(NewtonSteps, EndAtTheMinimumWithThePriors) {
  OneResidual line([](double x, double& r, double& J) { r = 2 * x - 6, J = 2; });
  calib::Estimate estimate = at(10.0, 1.0, 0.5);
  const calib::PassSum last = steps(line, estimate);
  EXPECT_TRUE(estimate.last.converged) << estimate.last.message;
  EXPECT_NEAR(estimate.x[0], 2.0, 1e-9);
  EXPECT_NEAR(estimate.last.cost, 0.5 * 4 + 0.5 * 4, 1e-9);
  EXPECT_EQ(last.system.whole(1).H(0, 0), 4.0);
  EXPECT_EQ(line.accepted, line.passes);
  EXPECT_LE(line.passes, 3);
}

// Gauss-Newton on atan diverges from beyond 1.39: such a step is undone and shortened.
TEST(NewtonSteps, TakeBackWhatMakesThingsWorse) {
  OneResidual bent([](double x, double& r, double& J) { r = 100 * std::atan(x), J = 100 / (1 + x * x); });
  calib::Estimate estimate = at(3.0);
  static_cast<void>(steps(bent, estimate));
  EXPECT_TRUE(estimate.last.converged) << estimate.last.message;
  EXPECT_NEAR(estimate.x[0], 0.0, 1e-4);
  EXPECT_LT(bent.accepted, bent.passes);
  EXPECT_TRUE(bent.never_worse);
}

TEST(NewtonSteps, GoOnWhileMarksChange) {
  OneResidual line([](double x, double& r, double& J) { r = x - 1, J = 1; });
  line.changes_left = 5;
  calib::Estimate estimate = at(1.0);
  static_cast<void>(steps(line, estimate));
  EXPECT_TRUE(estimate.last.converged);
  EXPECT_EQ(line.changes_left, 0);
  EXPECT_EQ(line.passes, 6);
}

TEST(NewtonSteps, BeginWithAReadingThatIsKnown) {
  OneResidual line([](double x, double& r, double& J) { r = x - 1, J = 1; });
  calib::Estimate estimate = at(1.0);
  const auto first = must(line.pass(estimate, calib::RejectionPolicy::kFirst));
  static_cast<void>(steps(line, estimate, first));
  EXPECT_EQ(line.passes, 1);
  EXPECT_EQ(estimate.x[0], 1.0);
}

TEST(NewtonSteps, StopWhereTheyAreAskedTo) {
  OneResidual line([](double x, double& r, double& J) { r = x - 1, J = 1; });
  calib::Estimate estimate = at(0.0);
  const calib::Problem frame;
  calib::SolveOptions options;
  options.on_progress = [](const calib::Progress&) { return false; };
  calib::ProgressMonitor monitor(options);
  const auto done = calib::newton_steps(line, frame, options, monitor, {}, estimate);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kInterrupted);
  EXPECT_EQ(line.passes, 0);
}

}  // namespace newton_steps_test
}  // namespace octant::test
