// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/repeated_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace octant::io {
namespace repeated_rows_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Arrival row(double time_s, int beacon, double tof_s, int line) {
  Arrival a;
  a.time_s = time_s;
  a.beacon = BeaconId(beacon);
  a.receiver = ReceiverId(0);
  a.vehicle = VehicleId(0);
  a.tof_s = tof_s;
  a.line = line;
  return a;
}

TEST(RepeatedRows, AreDroppedWhateverStandsBetweenThem) {
  std::vector<Arrival> all = {row(1, 0, 0.01, 2),  row(1, 1, 0.02, 3), row(1, 0, 0.01, 4),
                              row(1, 0, 0.011, 5), row(2, 0, 0.01, 6), row(2, 0, 0.01, 7)};
  RepeatedRows repeated;
  EXPECT_THAT(repeated.drop(all, 0), ElementsAre(4, 7));
  EXPECT_EQ(all.size(), 4U);
  EXPECT_EQ(all.back().line, 6);
}

TEST(RepeatedRows, AcrossPieces) {
  RepeatedRows repeated;
  std::vector<Arrival> piece = {row(1, 0, 0.01, 2), row(2, 1, 0.02, 3)};
  EXPECT_THAT(repeated.drop(piece, 0), IsEmpty());
  piece.push_back(row(2, 1, 0.02, 4));
  piece.push_back(row(3, 1, 0.02, 5));
  EXPECT_THAT(repeated.drop(piece, 2), ElementsAre(4));
  std::vector<Arrival> next = {row(3, 1, 0.02, 6)};
  EXPECT_THAT(repeated.drop(next, 0), ElementsAre(6));
  EXPECT_THAT(next, IsEmpty());
}

TEST(RepeatedRows, ManyRowsOfOneTime) {
  std::vector<Arrival> all;
  for (int copy = 0; copy < 2; ++copy)
    for (int i = 0; i < 500; ++i) all.push_back(row(1, i % 7, 0.01 + 1e-5 * i, 2 + i + 500 * copy));
  RepeatedRows repeated;
  EXPECT_EQ(repeated.drop(all, 0).size(), 500U);
  EXPECT_EQ(all.size(), 500U);
}

TEST(RepeatedRows, AnotherAmplitudeIsAnotherMeasurement) {
  std::vector<Arrival> all = {row(1, 0, 0.01, 2), row(1, 0, 0.01, 3)};
  all[1].amplitude_v = 2.0;
  RepeatedRows repeated;
  EXPECT_THAT(repeated.drop(all, 0), IsEmpty());
}

}  // namespace repeated_rows_test
}  // namespace octant::io
