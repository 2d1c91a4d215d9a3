// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/continued_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/io/io_support.h"

namespace octant::io {
namespace continued_clock_test {

using ::testing::HasSubstr;

std::vector<double> continued(const std::vector<double>& times, ContinuedClock& clock) {
  std::vector<double> all = {times.front()};
  for (std::size_t i = 1; i < times.size(); ++i)
    all.push_back(clock.continued(times[i], all.back(), static_cast<int>(i)));
  return all;
}

TEST(ContinuedClock, CountersAndTheTimeOfDayGoOn) {
  for (const double period_s : {4294.967296, 4294967.296, 86400.0, 604800.0}) {
    ContinuedClock clock;
    const auto times = continued({period_s - 0.1, period_s - 0.05, 0.0, 0.05, 0.1}, clock);
    EXPECT_DOUBLE_EQ(times[2], period_s);
    EXPECT_DOUBLE_EQ(times[4], period_s + 0.1);
    EXPECT_EQ(clock.period_s(), period_s);
    ASSERT_TRUE(clock.note("run/tof.csv"));
    EXPECT_THAT(*clock.note("run/tof.csv"), HasSubstr("run/tof.csv:2: time_s starts again at 0 after"));
  }
}

TEST(ContinuedClock, MayStartAgainSeveralTimesAndFromAnyOrigin) {
  EXPECT_TRUE(rc::check("any origin, any step below a hundredth of the period", [] {
    const double origin_s = *rc::gen::inRange(-5000, 5000), step_s = *rc::gen::inRange(1, 42),
                 period_s = 4294.967296;
    ContinuedClock clock;
    double last_s = 0.0;
    for (int i = 0; i < 500; ++i) {
      const double time_s = step_s * i,
                   counter_s = time_s - period_s * std::floor(time_s / period_s) - origin_s;
      last_s = i == 0 ? counter_s : clock.continued(counter_s, last_s, i);
      RC_ASSERT(std::abs(last_s - (time_s - origin_s)) < 1e-8);
    }
  }));
}

TEST(ContinuedClock, OtherStepsBackStay) {
  ContinuedClock clock;
  EXPECT_EQ(continued({10.0, 9.0, 100.0, 0.0}, clock), (std::vector<double>{10.0, 9.0, 100.0, 0.0}));
  EXPECT_EQ(continued({3000.0, 0.02}, clock).back(), 0.02) << "the device was switched off and on";
  EXPECT_FALSE(clock.note("f"));
}

TEST(ContinuedClock, RowsFromBeforeTheRestartMayComeAfterIt) {
  ContinuedClock clock;
  const auto times = continued({86399.8, 0.1, 86399.9, 0.2}, clock);
  EXPECT_NEAR(times[1], 86400.1, 1e-9);
  EXPECT_NEAR(times[2], 86399.9, 1e-9);
  EXPECT_NEAR(times[3], 86400.2, 1e-9);
}

std::string unit_of(double first_s, double step_s, int rows) {
  TimeUnitCheck check;
  for (int i = 0; i < rows; ++i) check.add(first_s + step_s * i);
  return check.note("tof.csv").value_or("");
}

TEST(TimeUnitCheck, NamesTheUnitOfWholeNumbers) {
  EXPECT_THAT(unit_of(0, 50, 4000), HasSubstr("milliseconds"));
  EXPECT_THAT(unit_of(7, 17, 10000), HasSubstr("milliseconds"));
  EXPECT_THAT(unit_of(0, 50000, 4000), HasSubstr("microseconds"));
  EXPECT_THAT(unit_of(0, 5e7, 4000), HasSubstr("nanoseconds"));
  EXPECT_THAT(unit_of(1.7e18, 5e7, 4000), HasSubstr("nanoseconds"));
}

TEST(TimeUnitCheck, NamesTheUnitOfStamps) {
  EXPECT_THAT(unit_of(1.7e12, 0.5, 4), HasSubstr("milliseconds"));
  EXPECT_THAT(unit_of(1.7e15, 3, 4), HasSubstr("microseconds"));
  EXPECT_THAT(unit_of(1.7e18, 512, 4), HasSubstr("nanoseconds"));
  EXPECT_EQ(unit_of(1.7e9, 0.5, 4), "") << "seconds since 1970";
}

TEST(TimeUnitCheck, SecondsStay) {
  EXPECT_EQ(unit_of(0, 1, 4000), "") << "one a second";
  EXPECT_EQ(unit_of(0, 1, 100000), "") << "one a second, all day";
  EXPECT_EQ(unit_of(0, 100, 30), "") << "thirty stops, some minutes apart";
  EXPECT_EQ(unit_of(0.25, 50, 4000), "") << "counters have no fractions";
}

}  // namespace continued_clock_test
}  // namespace octant::io
