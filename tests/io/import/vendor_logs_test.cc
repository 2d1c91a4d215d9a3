// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/vendor_logs.h"

#include "tests/io/io_support.h"

namespace octant::io::test {
namespace vendor_logs_test {

using ::testing::HasSubstr;

/// The tof.csv that a log becomes.
std::string tof_of(Result<ImportedLog> log, std::optional<double> speed_mps = {}) {
  if (!log) return log.error().message();
  const auto files = run_files(*log, "run", speed_mps);
  return files ? files->front().content : files.error().message();
}

TEST(VendorLogs, AMarvelmindDashboardsRawDistances) {
  const TemporaryFolder box;
  // With the UNIX time, and without it, as in files of older dashboards; zero: not received.
  const std::string with = box.write("a.csv",
                                     "1527774071500,0,1200,5,1.20,2.30,0.10,2,3.210,3,4.500,4,0.000\n"
                                     "1527774071700,200,1400,5,1.21,2.30,0.10,2,3.220,3,4.490,4,5.100\r\n");
  EXPECT_EQ(tof_of(read_marvelmind_log(with)),
            "time_s,beacon,distance_m\n1527774071.5,2,3.21\n1527774071.5,3,4.5\n1527774071.7,2,3.22\n"
            "1527774071.7,3,4.49\n1527774071.7,4,5.1\n");
  EXPECT_EQ(tof_of(read_marvelmind_log(box.write("b.csv", "0,1200,5,1.2,2.3,0.1,2,3.21,3,4.5,\n"))),
            "time_s,beacon,distance_m\n1.2,2,3.21\n1.2,3,4.5\n");
  // Two hedgehogs are two receivers; a neighbour's beacon is counted.
  auto log = read_marvelmind_log(box.write("c.csv",
                                           "1000,0,1,5,1,2,0,2,3.43,9,7\n"
                                           "1100,0,1,6,1,2,0,2,6.86,9,7\n"),
                                 {.ignore = {"9"}});
  ASSERT_TRUE(log);
  EXPECT_EQ(log->ignored.at("9"), 2U);
  EXPECT_EQ(tof_of(*log, 343.0), "time_s,beacon,tof_s,receiver\n1,2,0.01,5\n1.1,2,0.02,6\n");
  expect_error(read_marvelmind_log(box.write("d.csv", "1000,0,1,5,1,2,0,2,3.4\n1000,far,1\n")), 2,
               "3 fields");
  expect_error(read_marvelmind_log(box.write("e.csv", "1000,0,1,5,1,2,0,2,far\n")), 1, "'far'");
  expect_error(read_marvelmind_log(box.write("f.csv", "T,0,1,5,1,2,0,2,3\n")), 1, "'T'");
}

TEST(VendorLogs, ACrazyfliesTwoWayRanges) {
  const TemporaryFolder box;
  const std::string log = box.write(
      "cf.csv",
      "Timestamp,stateEstimate.x,ranging.state,ranging.distance0,ranging.distance1,ranging.distance7\n"
      "1000,0.1,129,1.5,2.25,3.125\n"
      "1100,0.1,131,1.5,2.5,3.25\n"
      "1200,0.1,131,1.625,2.75,\n");
  EXPECT_EQ(tof_of(read_crazyflie_log(log)),
            "time_s,beacon,distance_m\n1,0,1.5\n1,7,3.125\n1.1,1,2.5\n1.1,7,3.25\n1.2,0,1.625\n1.2,1,2.75\n");
  const auto read = read_crazyflie_log(log);
  EXPECT_THAT(read->warnings.back(), HasSubstr("1 distances that are exactly the ones before"));
  EXPECT_EQ(read->not_heard, 2U) << "an anchor whose bit is not set, and an empty cell";
  expect_error(read_crazyflie_log(box.write("tdoa.csv", "timestamp,tdoa2.d7-0\n1,0.5\n")), 1,
               "set the anchors to TWR");
  expect_error(read_crazyflie_log(box.write("none.csv", "Timestamp,pm.vbat\n1,3.7\n")), 1,
               "no column ranging.distance0");
  expect_error(read_crazyflie_log(box.write("bad.csv", "Timestamp,ranging.distance0\n1,near\n")), 2, "near");
  expect_error(read_crazyflie_log(box.write("no_time.csv", "ranging.distance0\n1\n")), 1, "timestamp");
}

TEST(VendorLogs, WhatADwm1001Says) {
  const TemporaryFolder box;
  const std::string lec =
      "DIST,2,AN0,1151,5.00,8.00,2.25,6.44,AN1,0CA8,0.00,8.00,2.25,6.50,POS,3.1,4.2,1.9,98";
  const std::string les =
      "1151[5.00,8.00,2.25]=6.44 0CA8[0.00,8.00,2.25]=6.50 le_us=2576 est[3.1,4.2,1.9,98]";
  const std::string rows = ",1151,6.44\n", other = ",0CA8,6.5\n";
  const auto tof = [&](const std::string& text, VendorLogOptions options = {}) {
    return tof_of(read_dwm1001_log(box.write("dwm.log", text), options));
  };
  const std::string head = "time_s,beacon,distance_m\n";
  // Times as written by any terminal.
  for (const auto& [before, time] : {std::pair("12.5 ", "12.5"),
                                     {"1630180636.250,", "1630180636.25"},
                                     {"1630180636250: ", "1630180636.25"},
                                     {"[2021-08-28 19:57:16.250] ", "1630180636.25"},
                                     {"2021-08-28T19:57:16.25Z ", "1630180636.25"},
                                     {"19:57:16.250 -> ", "71836.25"}}) {
    for (const std::string& payload : {lec, les})
      EXPECT_EQ(tof("dwm> lec\n" + (before + payload) + "\r\n"), head + time + rows + time + other) << before;
  }
  EXPECT_EQ(tof(lec + "\n" + les + "\n", {.period_s = 0.1}),
            head + "0" + rows + "0" + other + "0.1" + rows + "0.1" + other);
  // Past midnight.
  EXPECT_EQ(tof("23:59:59.9 " + les + "\n00:00:00.4 " + les + "\n"),
            head + "86399.9" + rows + "86399.9" + other + "86400.4" + rows + "86400.4" + other);
  // At high rates the module writes over its own words.
  const auto garbled = read_dwm1001_log(box.write(
      "g.log", "1 DIST,4,AN0,0090,0.00,0.00,0.00,3.25,AN3,15BA,0.00,0,AN3,15BB,0.00,0.00,0.00,1.50\n"));
  ASSERT_TRUE(garbled);
  EXPECT_EQ(garbled->arrivals.size(), 2U);
  EXPECT_THAT(garbled->warnings.back(), HasSubstr("1 garbled"));
  auto neighbour = read_dwm1001_log(box.path("dwm.log"), {.ignore = {"0CA8"}});
  ASSERT_TRUE(neighbour);
  EXPECT_EQ(neighbour->ignored_rows(), 2U);
  expect_error(read_dwm1001_log(box.write("n.log", "hello\n" + lec + "\n")), 2, "--period-s");
  expect_error(read_dwm1001_log(box.write("m.log", "yesterday " + lec + "\n")), 1, "no time in 'yesterday '");
  expect_error(read_dwm1001_log(box.write("o.log", "dwm> lep\nPOS,1,2,3,90\n")), 0, "no line that a DWM1001");
}

}  // namespace vendor_logs_test
}  // namespace octant::io::test
