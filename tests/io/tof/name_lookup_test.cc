// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/run_parts.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace name_lookup_test {

using testing::HasSubstr;

const NameTable kFleet{.beacons = {"B0", "B1", "B2"},
                       .vehicles = {"cart", "robot", "drone"},
                       .receivers = {{"l", VehicleId(0)}, {"l", VehicleId(1)}, {"r", VehicleId(1)}}};

TEST(NameLookup, NamesAreIdsAndReceiversAreTheirVehicles) {
  const NameLookup names(kFleet);
  EXPECT_EQ(names.beacon("B2"), BeaconId(2));
  EXPECT_FALSE(names.beacon("b2").valid());
  EXPECT_FALSE(names.beacon("").valid());
  EXPECT_EQ(names.vehicle("drone"), VehicleId(2));
  EXPECT_FALSE(names.vehicle("B0").valid());
  EXPECT_EQ(names.receiver(VehicleId(0), "l"), ReceiverId(0));
  EXPECT_EQ(names.receiver(VehicleId(1), "l"), ReceiverId(1));
  EXPECT_EQ(names.receiver(VehicleId(1), "r"), ReceiverId(2));
  EXPECT_FALSE(names.receiver(VehicleId(0), "r").valid()) << "it is the robot's";
  EXPECT_FALSE(names.receiver(VehicleId(2), "l").valid());
}

TEST(NameLookup, ARowThatNamesNoneMeansTheOnlyOneOrTheRobot) {
  EXPECT_EQ(NameLookup(kFleet).vehicle(""), VehicleId(1)) << "robot";
  const NameTable single{.beacons = {"B0"}, .vehicles = {"trolley"}, .receivers = {{"t", VehicleId(0)}}};
  EXPECT_EQ(NameLookup(single).vehicle(""), VehicleId(0));
  EXPECT_EQ(NameLookup(single).receiver(VehicleId(0), ""), ReceiverId(0));
  const NameTable two{.beacons = {"B0"}, .vehicles = {"a", "b"}, .receivers = {}};
  EXPECT_FALSE(NameLookup(two).vehicle("").valid());
  const NameLookup fleet(kFleet);
  EXPECT_EQ(fleet.receiver(VehicleId(0), ""), ReceiverId(0)) << "the cart's only one";
  EXPECT_FALSE(fleet.receiver(VehicleId(1), "").valid()) << "the robot has two";
  EXPECT_FALSE(fleet.receiver(VehicleId(2), "").valid()) << "the drone has none";
  NameLookup told(kFleet);
  told.default_vehicle = VehicleId(0);
  EXPECT_EQ(told.vehicle(""), VehicleId(0)) << "what run.yaml says";
}

/// Result for the cells of the first row.
std::string said(const NameTable& table, const std::string& text) {
  CsvReader csv(text, "run/tof.csv");
  const NameLookup names(table);
  BeaconId beacon;
  VehicleId vehicle;
  ReceiverId receiver;
  EXPECT_TRUE(csv.next_row());
  const bool found = names.beacon(csv, csv.find("beacon"), beacon) &&
                     names.vehicle(csv, csv.find("vehicle"), vehicle) &&
                     names.receiver(csv, csv.find("receiver"), vehicle, receiver);
  EXPECT_EQ(found, !csv.error());
  return csv.error() ? csv.error()->message() : "";
}

TEST(NameLookup, AllBeaconsThatTheSiteLacksAreNamedAtOnce) {
  const std::string text = said(kFleet, "beacon\nX1\nB0\nX2\nX1\nX3\nX2\n");
  EXPECT_THAT(
      text,
      HasSubstr("run/tof.csv:2:1: beacon 'X1' is not in the site, nor are X2, X3; expected a beacon's id"));
  EXPECT_THAT(text, HasSubstr("octant convert run/tof.csv --ignore 'X1' -o RUN"));
  EXPECT_THAT(said(kFleet, "beacon\nX1\nB0\nX2\n"), HasSubstr("nor is X2"));
  EXPECT_THAT(said(kFleet, "beacon\nX1\nB0\n"), HasSubstr("'X1' is not in the site; expected"));
  EXPECT_THAT(said(kFleet, "beacon\nb1\n"), HasSubstr("did you mean 'B1'? Or add it"));
  EXPECT_THAT(said(kFleet, "beacon,x\n,1\n"), HasSubstr("beacon is empty; expected a beacon's id"));
}

TEST(NameLookup, OfVeryManyUnknownBeaconsSomeAreNamed) {
  std::string text = "beacon\nX\n";
  for (int i = 0; i < 1000; ++i) text += "Y" + std::to_string(i) + "\n";
  const std::string message = said(kFleet, text);
  EXPECT_THAT(message, HasSubstr("nor are Y0, Y1"));
  EXPECT_LT(message.size(), 1000U);
}

TEST(NameLookup, VehiclesAndReceiversAreNamedWithWhatThereIs) {
  EXPECT_THAT(said(kFleet, "beacon,vehicle\nB0,cat\n"), HasSubstr(":2:4: vehicle 'cat' is not in the site"));
  EXPECT_THAT(said(kFleet, "beacon,vehicle\nB0,cat\n"), HasSubstr("did you mean 'cart'?"));
  EXPECT_THAT(said(kFleet, "beacon,receiver\nB0,x\n"),
              HasSubstr(":2:4: receiver 'x' is not on vehicle 'robot'"));
  EXPECT_THAT(said(kFleet, "beacon,receiver\nB0,x\n"), HasSubstr("known: l, r"));
  EXPECT_THAT(said(kFleet, "beacon\nB0\n"), HasSubstr("names no receiver, and vehicle 'robot' has 2"));
  EXPECT_THAT(said(kFleet, "beacon\nB0\n"), HasSubstr("add a column 'receiver'"));
  EXPECT_THAT(said(kFleet, "beacon,vehicle\nB0,drone\n"), HasSubstr("list its receivers in the site file"));
  const NameTable two{.beacons = {"B0"}, .vehicles = {"a", "b"}, .receivers = {}};
  EXPECT_THAT(said(two, "beacon\nB0\n"), HasSubstr("names no vehicle, and the site has 2"));
  EXPECT_EQ(said(kFleet, "beacon,vehicle,receiver\nB0,robot,r\n"), "");
}

}  // namespace name_lookup_test
}  // namespace octant::io
