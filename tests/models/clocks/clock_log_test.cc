// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/clocks/clock_log.h"

#include <gtest/gtest.h>

namespace octant::test {
namespace clock_log_test {

TimeDifference row(double time_s, int a, int b, double tdoa_s) {
  return {.time_s = time_s,
          .a = BeaconId(a),
          .b = BeaconId(b),
          .tdoa_s = tdoa_s,
          .vehicle = VehicleId(0),
          .receiver = ReceiverId(0)};
}

TEST(ClockLog, CombinesDifferencesOfOneSignalWithoutWildOnes) {
  const std::vector<double> t = {0.0, 1.0, 3.0, 6.0};
  std::vector<TimeDifference> rows;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < a; ++b) rows.push_back(row(5.0, a, b, t[b] - t[a]));
  rows[3].tdoa_s += 100.0;
  rows.push_back(row(7.0, 1, 2, 0.5));
  const std::vector<Transmission> all = transmissions_of(rows, 4);
  ASSERT_EQ(all.size(), 2U);
  ASSERT_EQ(all[0].receptions.size(), 4U);
  EXPECT_EQ(all[0].source, DeviceId(4));
  for (std::size_t b = 0; b < 4; ++b) EXPECT_NEAR(all[0].receptions[b].after_s, t[b], 1e-3);
  EXPECT_EQ(all[1].receptions[1].after_s, 0.5);
}

TEST(ClockLog, ArrivalsOfAWindowConnectTheBeacons) {
  std::size_t left_out = 0;
  const std::vector<Arrival> arrivals = arrivals_of(
      {row(1.00, 0, 1, 1.0), row(1.05, 1, 2, 2.0), row(1.06, 3, 4, 9.0), row(2.0, 0, 1, 1.5)}, left_out);
  ASSERT_EQ(arrivals.size(), 5U);
  EXPECT_EQ(left_out, 1U);
  EXPECT_NEAR(arrivals[2].tof_s, 3.0, 1e-9);
  EXPECT_EQ(arrivals[2].beacon, BeaconId(2));
  EXPECT_NE(arrivals[3].epoch, arrivals[2].epoch);
}

TEST(ClockLog, EarlierArrivalsTellWhichRowOfACircleIsWild) {
  const std::vector<double> t = {0.0, 1.0, 3.0, 6.0};
  std::vector<TimeDifference> rows;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < a; ++b) rows.push_back(row(1.0, a, b, t[b] - t[a] + 1e-3 * (a - b)));
  for (int a = 0; a < 4; ++a)
    rows.push_back(row(1.2, a, (a + 1) % 4, t[(a + 1) % 4] - t[a] + (a == 1 ? 50.0 : 0.0)));
  std::size_t left_out = 0;
  const std::vector<Arrival> arrivals = arrivals_of(rows, left_out);
  ASSERT_EQ(arrivals.size(), 8U);
  for (std::size_t b = 0; b < 4; ++b) EXPECT_NEAR(arrivals[4 + b].tof_s, t[b], 0.1);
}

}  // namespace clock_log_test
}  // namespace octant::test
