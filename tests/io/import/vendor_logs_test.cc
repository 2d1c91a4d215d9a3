// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/vendor_logs.h"

#include <fmt/format.h>

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

constexpr const char* kHead = "time_s,beacon,distance_m\n";

TEST(VendorLogs, ATrek1000sReports) {
  const TemporaryFolder box;
  const auto tof = [&](const std::string& text, VendorLogOptions options = {}) {
    return tof_of(read_kit_log("trek1000", box.write("trek.log", text), options));
  };
  const std::string raw = "mr 07 00000407 0000082b 000007a3 00000000 6cba 09 40414041 a0:0\n",
                    anchors = "ma 0e 00000000 000006d9 0000069c 0000026b 6cbd 51 00000bb8 a0:0\n",
                    corrected = "mc 05 000004ec 000008ee 0000087e 00000000 6cc0 0a 00000bb8 a0:0\n";
  // The corrected ranges have a time [ms]; two of them are valid.
  EXPECT_EQ(tof(raw + anchors + corrected), std::string(kHead) + "3,0,1.26\n3,2,2.174\n");
  EXPECT_EQ(tof("10.5 " + corrected), std::string(kHead) + "10.5,0,1.26\n10.5,2,2.174\n");
  EXPECT_EQ(tof("10.5 " + raw), std::string(kHead) + "10.5,0,1.031\n10.5,1,2.091\n10.5,2,1.955\n");
  EXPECT_EQ(tof(corrected + "mc 01 000003e8 00000000 00000000 00000000 6cc1 0b 00000fa0 a1:0\n"),
            "time_s,beacon,distance_m,receiver\n3,0,1.26,0\n3,2,2.174,0\n4,0,1,1\n");
  expect_error(read_kit_log("trek1000", box.write("n.log", raw)), 1, "--period-s");
  expect_error(read_kit_log("trek1000", box.write("m.log", "mc 05 xyz\n")), 0, "no line with ranges");
}

TEST(VendorLogs, WhatMakerfabsModulesSend) {
  const TemporaryFolder box;
  const auto tof = [&](const std::string& text, VendorLogOptions options = {}) {
    return tof_of(read_kit_log("makerfabs", box.write("m.log", text), options));
  };
  const std::string links = "{\"links\":[{\"A\":\"1782\",\"R\":\"1.25\"},{\"A\":\"1783\",\"R\":2.5}]}\n";
  EXPECT_EQ(tof("ready\n0.5 " + links + "1.5 {\"links\":[{\"A\":\"17\n"),
            std::string(kHead) + "0.5,1782,1.25\n0.5,1783,2.5\n");
  EXPECT_EQ(tof(links + links, {.period_s = 0.5}),
            std::string(kHead) + "0,1782,1.25\n0,1783,2.5\n0.5,1782,1.25\n0.5,1783,2.5\n");
  EXPECT_EQ(tof("{\"tag\":\"R1\",\"t_ms\":1500,\"links\":[{\"A\":\"1786\",\"R\":2.5}]}\n"),
            std::string(kHead) + "1.5,1786,2.5\n");
  EXPECT_EQ(tof("2 {\"id\":1,\"range\":[0,250,30]}\n"), std::string(kHead) + "2,1,2.5\n2,2,0.3\n");
  EXPECT_EQ(tof("2026-06-11 11:33:48 "
                "AT+RANGE=tid:7,mask:0F,seq:128,range:(997,1321,0,0,0,0,0,0),ancid:(4,1,2,-1,-1,-1,-1,-1)\n"),
            std::string(kHead) + "1781177628,4,9.97\n1781177628,1,13.21\n");
  EXPECT_EQ(tof("12:00:01 -> from: 1782\t Range: 2.35 m\t RX power: -72.30 dBm\n"),
            std::string(kHead) + "43201,1782,2.35\n");
  expect_error(read_kit_log("makerfabs", box.write("n.log", links)), 1, "--period-s");
}

TEST(VendorLogs, APozyxsRanges) {
  const TemporaryFolder box;
  EXPECT_EQ(tof_of(read_kit_log(
                "pozyx",
                box.write("a.log", "START Ranging:\n1500ms, 2345mm, -80dBm\n1600 ms, 2350 mm, -81 dBm\n"))),
            std::string(kHead) + "1.5,anchor,2.345\n1.6,anchor,2.35\n");
  EXPECT_EQ(tof_of(read_kit_log("pozyx", box.write("b.log", "10 0x6069: 1500 ms, 2345 mm, -80 dBm\n"))),
            std::string(kHead) + "10,0x6069,2.345\n");
}

/// A frame with its sum; `body` begins behind the length.
std::string frame(char kind, std::string body) {
  std::string bytes = std::string("\x55") + kind;
  if (kind != 1) {
    const std::size_t size = body.size() + 5;
    bytes += {static_cast<char>(size & 0xFF), static_cast<char>(size >> 8)};
  }
  bytes += body;
  unsigned sum = 0;
  for (const char c : bytes) sum += static_cast<unsigned char>(c);
  return bytes + static_cast<char>(sum & 0xFF);
}

std::string little_endian(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFF);
  return text;
}

TEST(VendorLogs, FramesOfLinktrackModules) {
  const TemporaryFolder box;
  const auto node = [](char role, char id, std::uint32_t range_mm, std::size_t more) {
    return std::string({role, id}) + little_endian(range_mm, 3) + std::string(more, '\0');
  };
  // Tag 3, time 1.5 s, two anchors.
  const std::string third = frame(5, std::string({2, 3}) + little_endian(1500, 4) + std::string(10, '\0') +
                                         '\2' + node(1, 0, 1250, 2) + node(1, 4, 2500, 2));
  const std::string second = frame(4, std::string({2, 3}) + std::string(96, '\0') + little_endian(2000, 4) +
                                          std::string(12, '\0') + '\1' + node(1, 4, 2750, 8));
  std::string distances;
  for (const std::uint32_t range_mm : {1000U, 0U, 3000U, 0U, 0U, 0U, 0U, 0U})
    distances += little_endian(range_mm, 3);
  const std::string tag =
      frame(1, std::string({3, 2}) + std::string(18, '\0') + distances + std::string(62, '\0') +
                   little_endian(2500, 4) + std::string(15, '\0'));
  const std::string rows = "1.5,A0,1.25\n1.5,A4,2.5\n2,A4,2.75\n2.5,A0,1\n2.5,A2,3\n";
  const std::string log = box.write("link.bin", "noise" + third + second + "U" + tag);
  EXPECT_EQ(tof_of(read_kit_log("linktrack", log)), kHead + rows);
  EXPECT_EQ(kit_of(log), "linktrack");
  std::string text;
  for (const char c : third + second + tag) text += fmt::format("{:02X} ", static_cast<unsigned char>(c));
  EXPECT_EQ(tof_of(read_kit_log("linktrack", box.write("link.txt", text))), kHead + rows);
  std::string damaged = third;
  damaged[12] = '\7';
  const auto some = read_kit_log("linktrack", box.write("bad.bin", damaged + second));
  ASSERT_TRUE(some);
  EXPECT_EQ(some->arrivals.size(), 1U);
  EXPECT_THAT(some->warnings.front(), HasSubstr("belong to no frame"));
}

TEST(VendorLogs, KitsAreRecognised) {
  const TemporaryFolder box;
  const std::pair<const char*, const char*> logs[] = {
      {"marvelmind",
       "1527774071500,0,1200,5,1.20,2.30,0.10,2,3.210,3,4.500\n1527774071700,200,1400,5,1.21,2.30,0.10,2,3."
       "220,3,4.490\n"},
      {"crazyflie", "Timestamp,ranging.state,ranging.distance0\n1000,1,1.5\n"},
      {"dwm1001", "dwm> lec\n1.5 DIST,1,AN0,1151,5.00,8.00,2.25,6.44\n"},
      {"trek1000", "mc 07 000004ec 000008ee 0000087e 00000000 6cc0 0a 00a0642b a0:0\n"},
      {"makerfabs", "WiFi connected\n{\"links\":[{\"A\":\"1782\",\"R\":\"1.03\"}]}\n"},
      {"makerfabs", "AT+RANGE=tid:0,mask:01,seq:65,range:(92,0,0,0,0,0,0,0),rssi:(0.00,0.00)\n"},
      {"pozyx", "1500ms, 2345mm, -80dBm\n"},
      {"", "time,anchor,distance\n1,2,3\n"},
      {"", "0.1,5.12,6.23,7.34,8.1,9.1,2.5,3.5\n0.2,5.13,6.24,7.35,8.2,9.1,2.5,3.5\n"},
      {"", "t_ms,range_mm\n0,5100\n"},
      {"", ""}};
  for (const auto& [kit, text] : logs) EXPECT_EQ(kit_of(box.write("log", text)), kit) << text;
}

}  // namespace vendor_logs_test
}  // namespace octant::io::test
