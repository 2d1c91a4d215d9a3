// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/trend/trend.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "models/watch/cusum.h"

namespace octant::survey {
namespace trend_test {

constexpr double kMonth = 30.0 * 86400.0;

std::vector<TrendValue> level(Random& draws, int count, double sigma, double step_sigmas = 0.0,
                              int step_at = 0) {
  std::vector<TrendValue> values;
  for (int i = 0; i < count; ++i) {
    const double own = sigma * (1.0 + (i % 3));  // calibrations differ in how well they know
    values.push_back(
        {i * kMonth, 3.0 + own * draws.normal() + (i >= step_at ? step_sigmas * sigma : 0.0), own});
  }
  return values;
}

// The first value is as uncertain as the others: deviations from what came before must still be N(0, 1).
TEST(ControlChart, DeviationsAreIndependentOfUnitVariance) {
  Random draws(2);
  double squares = 0.0, products = 0.0;
  int count = 0;
  for (int chart = 0; chart < 500; ++chart) {
    const ControlChart c = control_chart(level(draws, 12, 0.002), 0.5, 1e9, 1e-5);
    for (std::size_t i = 1; i < c.points.size(); ++i, ++count) {
      squares += std::pow(c.points[i].deviation_sigmas, 2);
      if (i > 1) products += c.points[i].deviation_sigmas * c.points[i - 1].deviation_sigmas;
    }
  }
  EXPECT_NEAR(squares / count, 1.0, 4 * std::sqrt(2.0 / count));
  EXPECT_NEAR(products / count, 0.0, 4 / std::sqrt(static_cast<double>(count)));
}

TEST(ControlChart, AlarmsAreAsRareAsTheThresholdSays) {
  Random draws(3);
  const double visits_an_alarm = 300.0, h = cusum_threshold(0.5, visits_an_alarm);
  std::size_t alarms = 0;
  const int charts = 2000, visits = 20;
  for (int i = 0; i < charts; ++i)
    alarms += control_chart(level(draws, visits, 0.002), 0.5, h, 1e-5).shifts.size();
  // Charts begin at zero, so that the first few visits cannot alarm: at most the rate of the long run.
  const double expected = charts * (visits - 1) / visits_an_alarm;
  EXPECT_LT(static_cast<double>(alarms), expected + 4 * std::sqrt(expected));
  EXPECT_GT(static_cast<double>(alarms), 0.5 * expected);
}

TEST(ControlChart, AStepIsFoundWhereItWasAndMeasured) {
  const double h = cusum_threshold(0.5, 5000.0);
  int right = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random draws(seed);
    const double sigmas = seed % 2 == 0 ? 15.0 : -15.0;
    const ControlChart c = control_chart(level(draws, 16, 0.002, sigmas, 9), 0.5, h, 1e-5);
    ASSERT_EQ(c.shifts.size(), 1u) << seed;
    EXPECT_FALSE(c.shifts[0].by_drift);
    right += c.shifts[0].since == 9;
    EXPECT_LE(c.shifts[0].at, 11u);
    EXPECT_NEAR(c.shifts[0].size, sigmas * 0.002, 5 * c.shifts[0].sigma);
    EXPECT_EQ(c.points[c.shifts[0].at].alarm, sigmas > 0 ? 1 : -1);
    EXPECT_FALSE(c.points[c.shifts[0].since].foretold) << "the chart begins anew";
    ASSERT_TRUE(c.drift);
    EXPECT_LT(std::abs(c.drift->per_s), 4.5 * c.drift->sigma_per_s) << "a step is no drift";
  }
  EXPECT_GE(right, 38);
}

// Noticed some visits late, the new level still begins where the step was.
TEST(ControlChart, AnAlarmThatComesLateLosesNothing) {
  std::vector<TrendValue> values;
  for (int i = 0; i < 16; ++i) values.push_back({i * kMonth, i < 10 ? 0.0 : 3.0, 1.0});
  const ControlChart c = control_chart(values, 0.5, 6.0, 1e-5);
  ASSERT_EQ(c.shifts.size(), 1u);
  EXPECT_EQ(c.shifts[0].since, 10u);
  EXPECT_GT(c.shifts[0].at, 11u);
  EXPECT_FALSE(c.points[10].foretold);
  EXPECT_NEAR(c.points[11].foretold.value(), 3.0, 1e-12);
}

// A drift triggers the sums like a step. It must not be divided into steps, because no data would remain for
// a forecast.
TEST(ControlChart, ADriftIsToldFromSteps) {
  const double h = cusum_threshold(0.5, 5000.0);
  int drifts = 0, steps = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random draws(seed);
    auto values = level(draws, 20, 0.0005);
    for (TrendValue& v : values) v.value += 1e-3 * v.time_s / kMonth;
    const ControlChart c = control_chart(values, 0.5, h, 1e-5);
    for (const Shift& s : c.shifts) ++(s.by_drift ? drifts : steps);
    ASSERT_TRUE(c.drift);
    EXPECT_GT(c.drift->per_s, 3 * c.drift->sigma_per_s) << seed;
  }
  EXPECT_GT(drifts, 40);
  EXPECT_LT(steps, 0.1 * drifts);
}

TEST(ControlChart, AHeldPlaceThatIsStatedAnewIsAShift) {
  const ControlChart same =
      control_chart({{0, 2.0, 0}, {kMonth, 2.0, 0}, {2 * kMonth, 2.0, 0}}, 0.5, 6.0, 1e-5);
  EXPECT_TRUE(same.shifts.empty());
  const ControlChart moved =
      control_chart({{0, 2.0, 0}, {kMonth, 2.0, 0}, {2 * kMonth, 2.01, 0}}, 0.5, 6.0, 1e-5);
  ASSERT_EQ(moved.shifts.size(), 1u);
  EXPECT_NEAR(moved.shifts[0].size, 0.01, 1e-9);
}

// Slopes of drifting quantities within their sigmas, and dates that are correct as often as two sigmas imply.
TEST(Forecast, DatesHoldTheTruthAsOftenAsTheySay) {
  Random draws(5);
  const double per_s = 1e-3 / kMonth, limit = 0.03, true_s = limit / per_s;
  int held = 0;
  double chi2 = 0.0;
  const int charts = 1000, visits = 8;
  for (int i = 0; i < charts; ++i) {
    auto values = level(draws, visits, 0.0005);
    for (TrendValue& v : values) v.value += per_s * v.time_s;
    const ControlChart c = control_chart(values, 0.5, 1e9, 1e-5);
    ASSERT_TRUE(c.drift);
    chi2 += std::pow((c.drift->per_s - per_s) / c.drift->sigma_per_s, 2);
    const Forecast f = forecast(*c.drift, limit);
    const double due_s = c.drift->last_time_s + true_s;
    held += f.earliest_s <= due_s && (!f.latest_s || *f.latest_s >= due_s);
  }
  // Widening by the scatter makes the sigmas too large in places, never too small on average.
  EXPECT_LT(chi2 / charts, 1.0 + 4 * std::sqrt(2.0 / charts));
  EXPECT_GT(chi2 / charts, 0.5);
  EXPECT_GT(held, 0.93 * charts);
}

TEST(Forecast, WithoutADriftThereIsOnlyAnEarliestDate) {
  const Forecast f = forecast({.per_s = 1e-12, .sigma_per_s = 2e-12, .last_time_s = 1e9}, 0.01);
  EXPECT_FALSE(f.due_s || f.latest_s);
  EXPECT_NEAR(f.earliest_s, 1e9 + 0.01 / 5e-12, 1.0);
}

TEST(ControlChart, VisitsOfOneWeekTellNoDrift) {
  constexpr double kDay = 86400.0;
  EXPECT_FALSE(control_chart({{0, 1, 0.1}, {6 * kDay, 1.2, 0.1}}, 0.5, 5, 1e-5).drift);
  const ControlChart later = control_chart({{0, 1, 0.1}, {8 * kDay, 1.2, 0.1}}, 0.5, 5, 1e-5);
  ASSERT_TRUE(later.drift);
  EXPECT_NEAR(later.drift->per_s, 0.2 / (8 * kDay), 1e-12);
}

TEST(ControlChart, OneVisitOrNoneIsNoTrend) {
  EXPECT_TRUE(control_chart({}, 0.5, 5, 1e-5).points.empty());
  const ControlChart one = control_chart({{0, 1, 0.1}}, 0.5, 5, 1e-5);
  EXPECT_FALSE(one.drift);
  EXPECT_FALSE(one.points[0].foretold);
}

}  // namespace trend_test
}  // namespace octant::survey
