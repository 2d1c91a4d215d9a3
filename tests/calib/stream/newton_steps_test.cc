// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/newton_steps.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace octant::test {
namespace {

/// Readings of one residual, whose parameter is the only one.
class OneResidual : public calib::LogReadings {
 public:
  /// @param residual  sets value and derivative
  explicit OneResidual(std::function<void(double x, double& r, double& J)> residual)
      : residual_(std::move(residual)) {}
  Result<Placed> place(const calib::Estimate&, double, bool) override { return Placed{}; }
  Result<calib::PassSum> pass(const calib::Estimate& estimate, calib::MarkPolicy marks) override {
    double r = 0.0, J = 0.0;
    residual_(estimate.x[0], r, J);
    calib::PassSum sum;
    sum.system.cost = sum.counts.cost_before = 0.5 * r * r;
    sum.system.gradient.setConstant(1, J * r);
    sum.system.H.setConstant(1, 1, J * J);
    if (marks != calib::MarkPolicy::kKept && changes_left > 0) sum.counts.changed = 1, --changes_left;
    ++passes;
    return sum;
  }
  void accept() override { ++accepted; }
  Result<void> tell(const calib::Estimate&, calib::FindingsGatherer&) override { return {}; }

  int passes = 0, accepted = 0, changes_left = 0;

 private:
  std::function<void(double, double&, double&)> residual_;
};

calib::Estimate at(double x, double prior_mean = 0.0, double prior_sigma = INFINITY) {
  calib::Estimate estimate;
  estimate.layout.parameters.push_back({.prior_mean = prior_mean, .prior_sigma = prior_sigma});
  estimate.layout.blocks.push_back({0, 1});
  estimate.layout.speed = {0};
  estimate.layout.fixed.speed_offset_mps = {0.0};
  estimate.x.setConstant(1, x);
  return estimate;
}

calib::PassSum steps(OneResidual& readings, calib::Estimate& estimate,
                     std::optional<calib::PassSum> first = {}) {
  const calib::Problem frame;
  const calib::SolveOptions options;
  calib::Course course(options);
  return must(calib::newton_steps(readings, frame, options, course, std::move(first), estimate));
}

// Beside a prior: the minimum of 1/2 (2 x - 6)^2 + 1/2 ((x - 1) / 0.5)^2 is where 8 x = 16.
TEST(NewtonSteps, EndAtTheMinimumWithThePriors) {
  OneResidual line([](double x, double& r, double& J) { r = 2 * x - 6, J = 2; });
  calib::Estimate estimate = at(10.0, 1.0, 0.5);
  const calib::PassSum last = steps(line, estimate);
  EXPECT_TRUE(estimate.last.converged) << estimate.last.message;
  EXPECT_NEAR(estimate.x[0], 2.0, 1e-9);
  EXPECT_NEAR(estimate.last.cost, 0.5 * 4 + 0.5 * 4, 1e-9);
  EXPECT_EQ(last.system.H(0, 0), 4.0);
  EXPECT_EQ(line.accepted, line.passes);
  EXPECT_LE(line.passes, 3);
}

// Gauss-Newton on atan leaps farther and farther away from beyond 1.39: such a step is taken back and made
// shorter.
TEST(NewtonSteps, TakeBackWhatMakesThingsWorse) {
  OneResidual bent([](double x, double& r, double& J) { r = 100 * std::atan(x), J = 100 / (1 + x * x); });
  calib::Estimate estimate = at(3.0);
  static_cast<void>(steps(bent, estimate));
  EXPECT_TRUE(estimate.last.converged) << estimate.last.message;
  EXPECT_NEAR(estimate.x[0], 0.0, 1e-4);
  EXPECT_LT(bent.accepted, bent.passes);
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
  const auto first = must(line.pass(estimate, calib::MarkPolicy::kFirst));
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
  calib::Course course(options);
  const auto done = calib::newton_steps(line, frame, options, course, {}, estimate);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kInterrupted);
  EXPECT_EQ(line.passes, 0);
}

// What several readings say adds up; a mark that may come with placing is for one alone.
TEST(JoinedReadings, AddUp) {
  calib::JoinedReadings both;
  both.add(std::make_unique<OneResidual>([](double x, double& r, double& J) { r = 2 * x - 6, J = 2; }));
  both.add(std::make_unique<OneResidual>([](double x, double& r, double& J) { r = x, J = 1; }));
  const calib::PassSum sum = must(both.pass(at(1.0), calib::MarkPolicy::kKept));
  EXPECT_EQ(sum.system.cost, 0.5 * 16 + 0.5);
  EXPECT_EQ(sum.counts.cost_before, sum.system.cost);
  EXPECT_EQ(sum.system.gradient[0], -8.0 + 1.0);
  EXPECT_EQ(sum.system.H(0, 0), 5.0);
}

}  // namespace
}  // namespace octant::test
