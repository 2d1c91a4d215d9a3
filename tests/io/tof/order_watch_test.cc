// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/order_watch.h"

#include <map>
#include <set>

#include "tests/io/io_support.h"

namespace octant::io {
namespace order_watch_test {

TEST(OrderWatch, TimeMayStandStillAndNotGoBack) {
  OrderWatch watch(1, 0, 1);
  EXPECT_TRUE(watch.advance_time(-1e300));
  EXPECT_TRUE(watch.advance_time(1.0));
  EXPECT_TRUE(watch.advance_time(1.0));
  EXPECT_FALSE(watch.advance_time(0.999));
  EXPECT_FALSE(watch.advance_time(0.5)) << "what was refused changes nothing";
  EXPECT_TRUE(watch.advance_time(1.0));
}

TEST(OrderWatch, AnEpochIsOneBlockOfItsVehicle) {
  OrderWatch watch(2, 0, 1);
  const VehicleId robot(0), cart(1);
  EXPECT_TRUE(watch.advance_epoch(robot, 1));
  EXPECT_TRUE(watch.advance_epoch(cart, 1)) << "another vehicle's";
  EXPECT_TRUE(watch.advance_epoch(robot, 1));
  EXPECT_TRUE(watch.advance_epoch(robot, 2));
  EXPECT_TRUE(watch.advance_epoch(cart, 1)) << "rows of two vehicles mix";
  EXPECT_FALSE(watch.advance_epoch(robot, 1)) << "it had ended";
  EXPECT_TRUE(watch.advance_epoch(robot, 2)) << "what was refused changes nothing";
  EXPECT_TRUE(watch.advance_epoch(robot, -5)) << "numbers need not rise";
  EXPECT_FALSE(watch.advance_epoch(robot, 2));
}

TEST(OrderWatch, AgreesWithSetsOfWhatHasEnded) {
  EXPECT_TRUE(rc::check("any sequence of rows", [] {
    OrderWatch watch(2, 0, 1);
    std::map<std::size_t, std::set<std::int64_t>> ended;
    std::map<std::size_t, std::int64_t> current;
    for (int i = 0; i < 60; ++i) {
      const auto vehicle = *rc::gen::inRange<std::size_t>(0, 2);
      const std::int64_t last = current.contains(vehicle) ? current[vehicle] : 0;
      const std::int64_t epoch = *rc::gen::oneOf(rc::gen::just(last), rc::gen::just(last + 1),
                                                 rc::gen::inRange<std::int64_t>(-3, 12));
      const bool fine = (current.contains(vehicle) && last == epoch) || !ended[vehicle].contains(epoch);
      RC_ASSERT(watch.advance_epoch(VehicleId(vehicle), epoch) == fine);
      if (!fine) continue;
      if (current.contains(vehicle) && last != epoch) ended[vehicle].insert(last);
      current[vehicle] = epoch;
    }
  }));
}

/// Two rows of a file, and the finding for the second one.
std::string said(const std::string& first, const std::string& second) {
  const std::string text = "time_s,epoch\n" + first + "\n" + second + "\n";
  CsvReader csv(text, "t.csv");
  OrderWatch watch(1, csv.find("time_s"), csv.find("epoch"));
  while (csv.next_row()) {
    double time_s = 0;
    std::int64_t epoch = 0;
    if (!csv.number(0, time_s) || !csv.integer(1, epoch)) break;
    if (!watch.time(csv, time_s) || !watch.epoch(csv, VehicleId(0), epoch)) break;
  }
  return csv.error() ? csv.error()->message() : "";
}

TEST(OrderWatch, SaysAtTheCellWhatIsOutOfOrder) {
  EXPECT_EQ(said("1.5,1", "1.5,1"), "");
  EXPECT_THAT(said("1.5,1", "1.25,1"), testing::HasSubstr("t.csv:3:1: time_s goes back from 1.5 to 1.25"));
  EXPECT_THAT(said("1.5,1", "1.25,1"), testing::HasSubstr("sort the rows by time_s"));
  EXPECT_THAT(said("1,1\n1,2\n1,3", "10,1"),
              testing::HasSubstr("t.csv:5:4: epoch 1 comes back after epoch 3"));
}

}  // namespace order_watch_test
}  // namespace octant::io
