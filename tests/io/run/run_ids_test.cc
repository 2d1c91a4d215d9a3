// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_ids.h"

#include <algorithm>

#include "io/tof/run_parts.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace run_ids_test {

using test::expect_error;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::IsEmpty;

Result<RunIds> ids_of(const std::string& tof, const std::string& bearings = "") {
  const TemporaryFolder folder;
  if (!tof.empty()) folder.write("run/tof.csv", tof);
  if (!bearings.empty()) folder.write("run/bearings.csv", bearings);
  return read_run_ids(folder.path("run"));
}

TEST(RunIds, AreTheNamesOfTheRows) {
  const auto ids = ids_of(
      "time_s,beacon,tof_s,vehicle,receiver\n1,B10,0.01,cart,r1\n1,B2,0.01,cart,r0\n1,B2,0.01,,r9\n1,,0.01,,"
      "\n");
  ASSERT_TRUE(ids) << ids.error().message();
  EXPECT_THAT(ids->beacons, ElementsAre("B2", "B10"));
  ASSERT_EQ(ids->vehicles.size(), 2U);
  EXPECT_EQ(ids->vehicles[0].name, "cart");
  EXPECT_THAT(ids->vehicles[0].receivers, ElementsAre("r0", "r1"));
  EXPECT_EQ(ids->vehicles[1].name, "robot") << "of rows that name none";
  EXPECT_THAT(ids->vehicles[1].receivers, ElementsAre("r9"));
  EXPECT_FALSE(ids->has_epochs || ids->has_amplitudes);
}

TEST(RunIds, KnowWhichColumnsThereAre) {
  EXPECT_TRUE(ids_of("time_s,beacon,tof_s,epoch\n1,B,0.01,1\n")->has_epochs);
  EXPECT_TRUE(ids_of("time_s,beacon,tof_s,amplitude_v\n1,B,0.01,1\n")->has_amplitudes);
  EXPECT_TRUE(ids_of("time_s,beacon,tof_s,level_dbm\n1,B,0.01,1\n")->has_amplitudes);
  const auto plain = ids_of("time_s,beacon,tof_s\n1,B,0.01\n");
  EXPECT_THAT(plain->vehicles.at(0).receivers, IsEmpty());
}

TEST(RunIds, ReflectorsAreBeaconsToo) {
  const auto ids = ids_of("time_s,beacon,tof_s\n1,B1,0.01\n",
                          "time_s,reflector,bearing_rad,epoch\n1,M2,0.5,1\n2,B1,0.5,1\n");
  EXPECT_THAT(ids->beacons, ElementsAre("B1", "M2"));
  EXPECT_TRUE(ids->has_epochs);
  EXPECT_THAT(ids_of("", "time_s,reflector,bearing_rad\n1,M2,0.5\n")->beacons, ElementsAre("M2"));
}

/// Texts with every run of digits filled up to twenty: their plain order is the one that people expect.
std::string padded(const std::string& name) {
  std::string out, digits;
  const auto flush = [&] {
    if (!digits.empty()) out += std::string(20 - digits.size(), '0') + digits;
    digits.clear();
  };
  for (const char c : name) {
    if (c >= '0' && c <= '9') {
      digits += c;
    } else {
      flush();
      out += c;
    }
  }
  flush();
  return out;
}

TEST(RunIds, NumbersWithinNamesComeInTheirOrder) {
  EXPECT_TRUE(rc::check("as names filled up with zeros do, and none is lost", [] {
    auto names = *rc::gen::container<std::vector<std::string>>(rc::gen::nonEmpty(
        rc::gen::container<std::string>(rc::gen::element('a', 'b', '0', '1', '2', '9', '-', 'Z'))));
    RC_PRE(!names.empty());
    for (std::string& name : names) name = name.substr(0, 12);
    std::string text = "time_s,beacon,tof_s\n";
    for (const std::string& name : names) text += "1," + csv_field(name) + ",0.01\n";
    const auto ids = ids_of(text);
    RC_ASSERT(ids.has_value());
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    RC_ASSERT(ids->beacons.size() == names.size());
    std::stable_sort(names.begin(), names.end(),
                     [](const auto& a, const auto& b) { return padded(a) < padded(b); });
    RC_ASSERT(ids->beacons == names);
  }));
}

TEST(RunIds, LeadingZerosDoNotMakeTwoNamesOne) {
  EXPECT_THAT(ids_of("time_s,beacon,tof_s\n1,B1,1\n1,B01,1\n1,B001,1\n1,B2,1\n")->beacons,
              ElementsAre("B001", "B01", "B1", "B2"));
}

TEST(RunIds, NothingToNameIsAnError) {
  const TemporaryFolder folder;
  expect_error(read_run_ids(folder.path("none")), 0, "the run folder cannot be read", "none");
  expect_error(read_run_ids(folder.write("file", "x")), 0, "this is a file", "file");
  std::filesystem::create_directory(folder.path("empty"));
  expect_error(read_run_ids(folder.path("empty")), 0, "neither tof.csv nor bearings.csv", "empty");
  expect_error(ids_of("time_s,beacon,tof_s\n"), 0, "no row names a beacon");
  expect_error(ids_of("time_s,tof_s\n1,2\n"), 1, "column 'beacon' is missing", "tof.csv");
  expect_error(ids_of("time_s,beacon,tof_s\n1,B,1\n1,B\n"), 3, "cut off", "tof.csv");
}

TEST(RunIds, NamesWithoutEndAreRefused) {
  std::string text = "time_s,beacon,tof_s\n";
  for (int i = 0; i < 10'001; ++i) text += "1,B" + std::to_string(i) + ",0.01\n";
  expect_error(ids_of(text), 10'001, "more than 10000 names", "tof.csv");
}

}  // namespace run_ids_test
}  // namespace octant::io
