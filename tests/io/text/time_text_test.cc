// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/time_text.h"

#include <gtest/gtest.h>

namespace octant::io {
namespace time_text_test {

TEST(TimeText, NumbersDatesAndTimesOfDayAreSeconds) {
  const std::pair<const char*, double> cases[] = {{"12.5", 12.5},
                                                  {"-1e-3", -1e-3},
                                                  {"00:00:00", 0.0},
                                                  {"23:59:59.25", 86399.25},
                                                  {"9:05:07,5", 32707.5},
                                                  {"1970-01-02 00:00:00", 86400.0},
                                                  {"2026-06-11 11:33:48.686", 1781177628.686},
                                                  {"2026-06-11T11:33:48.686Z", 1781177628.686},
                                                  {"2026-06-11T13:33:48.686+02:00", 1781177628.686},
                                                  {"2026-06-11T06:33:48.686-0500", 1781177628.686},
                                                  {"2026/6/11 11:33:48", 1781177628.0},
                                                  {"11.06.2026 11:33:48", 1781177628.0},
                                                  {"11.06.26 11:33", 1781177580.0},
                                                  {"20260611T113348Z", 1781177628.0},
                                                  {"11-Jun-2026 11:33:48", 1781177628.0},
                                                  {"11-Okt-2026 11:33:48.5", 1791718428.5},
                                                  {"2026-06-11 11:33:48 UTC", 1781177628.0},
                                                  {"2026-06-11T13:33:48+02:00[Europe/Berlin]", 1781177628.0},
                                                  {"11:33:48:500", 41628.5},
                                                  {"1:33:48 PM", 48828.0},
                                                  {"12:00:01 am", 1.0}};
  for (const auto& [text, seconds] : cases) {
    const auto time_s = time_of_text(text);
    ASSERT_TRUE(time_s) << text;
    EXPECT_DOUBLE_EQ(*time_s, seconds) << text;
  }
}

TEST(TimeText, OtherTextIsNoTime) {
  for (const char* text : {"", "nan", "inf", "yesterday", "2026-06-11", "2026-02-30 00:00:00", "24:00:00",
                           "12:60:00", "12:00", "12:00:00 o'clock", "2026-06-11 11:33:48 +25:00", "1.2.3",
                           "06-11-2026 11:33:48", "2026-06-11 11:33:48-", "99999999999999999999:00:00"})
    EXPECT_FALSE(time_of_text(text)) << text;
}

TEST(TimeText, DatesWithSlashesHaveAnOrder) {
  EXPECT_FALSE(time_of_text("6/11/2026 11:33:48"));
  EXPECT_EQ(time_of_text("6/11/2026 11:33:48", DateOrder::kMonthFirst), 1781177628.0);
  EXPECT_EQ(time_of_text("11/6/2026 11:33:48", DateOrder::kDayFirst), 1781177628.0);
  EXPECT_FALSE(time_of_text("13/6/2026 11:33:48", DateOrder::kMonthFirst));
  EXPECT_FALSE(time_of_text("6/11/2026 13:33:48 PM", DateOrder::kMonthFirst));
  EXPECT_TRUE(is_date("2026-06-11"));
  EXPECT_TRUE(is_date("11.06.2026"));
  EXPECT_FALSE(is_date("2026"));
  EXPECT_FALSE(is_date("1.5"));
}

TEST(TimeText, StampsBeyondTheYear5138AreInASmallerUnit) {
  EXPECT_DOUBLE_EQ(seconds_of_stamp(1585909600.123), 1585909600.123);
  EXPECT_DOUBLE_EQ(seconds_of_stamp(1585909600123.0), 1585909600.123);
  EXPECT_DOUBLE_EQ(seconds_of_stamp(1585909600123456.0), 1585909600.123456);
  EXPECT_DOUBLE_EQ(seconds_of_stamp(1585909600123456789.0), 1585909600.123456789);
  EXPECT_DOUBLE_EQ(seconds_of_stamp(4294967295.0), 4294967295.0) << "a counter";
}

}  // namespace time_text_test
}  // namespace octant::io
