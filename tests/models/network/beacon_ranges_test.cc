// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/network/beacon_ranges.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/physics/medium.h"

namespace octant::test {
namespace beacon_ranges_test {

Site three_beacons() {
  Site site;
  site.medium.speed_mps = 300.0;
  site.timing.ranging = Ranging::kTwoWay;
  site.timing.turnaround_s = 0.5;
  site.timing.delay_s = 0.25;
  site.noise.tof_sigma_s = 1e-3;
  site.beacons.resize(3);
  return site;
}

TEST(BeaconRanges, CombinesBothDirectionsWithoutEchoes) {
  const BeaconId a(0), b(1), c(2);
  const BeaconRanges ranges = beacon_ranges(three_beacons(), {{0.0, a, b, 1.7501},
                                                              {1.0, b, a, 1.7499},
                                                              {2.0, a, b, 2.5},
                                                              {0.0, b, a, 1.75, 1},
                                                              {1.0, c, b, 1.25, 1},
                                                              {2.0, a, b, 1.7502, 1},
                                                              {3.0, a, b, 1.7498, 1}});
  ASSERT_EQ(ranges.pairs.size(), 2U);
  EXPECT_NEAR(ranges.pairs[0].tof_s, 1.0, 1e-12);
  EXPECT_EQ(ranges.pairs[0].used, 5U);
  EXPECT_EQ(ranges.pairs[0].left_out, 1U);
  EXPECT_EQ(ranges.pairs[0].model_speed_mps, 300.0);
  // A mean of five rows, and a bias of the size of the noise.
  EXPECT_NEAR(ranges.pairs[0].sigma_s, 1e-3 * std::sqrt(1.2), 1e-9);
  EXPECT_EQ(ranges.pairs[1].run, 1U);
}

TEST(BeaconRanges, AreCorrelatedByTheDelayOfACommonBeacon) {
  const BeaconId a(0), b(1), c(2);
  BeaconRanges ranges =
      beacon_ranges(three_beacons(), {{0.0, a, b, 1.7}, {1.0, b, c, 1.9}, {2.0, a, c, 2.0}});
  ranges.set_delay_sigma(2e-3);
  const Eigen::MatrixXd covariance = ranges.covariance(2e-3);
  EXPECT_NEAR(covariance(0, 1), 4e-6, 1e-15);
  EXPECT_NEAR(covariance(0, 0), 2e-6 + 8e-6, 1e-15);
  EXPECT_LT((ranges.root * covariance * ranges.root.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
}

TEST(BeaconRanges, CombineRecordingsAtDifferentTemperatures) {
  Site site = three_beacons();
  site.medium.model = MediumModel::kLinearTemperature;
  std::vector<MeasurementLog> runs(2);
  runs[0].temperature_degC = 0.0;
  runs[1].temperature_degC = 40.0;
  const double first_mps = speed_mps(site.medium, 0.0), second_mps = speed_mps(site.medium, 40.0);
  const BeaconRanges ranges = beacon_ranges(site,
                                            {{0.0, BeaconId(0), BeaconId(1), 0.75 + 300.0 / first_mps, 0},
                                             {0.0, BeaconId(0), BeaconId(1), 0.75 + 300.0 / second_mps, 1}},
                                            runs);
  ASSERT_EQ(ranges.pairs.size(), 1U);
  EXPECT_EQ(ranges.pairs[0].used, 2U);
  EXPECT_NEAR(ranges.pairs[0].tof_s * ranges.pairs[0].model_speed_mps, 300.0, 1e-9);
}

TEST(BeaconRanges, PreferTheEarlierHalfOfTheTimes) {
  const BeaconId a(0), b(1);
  const BeaconRanges ranges = beacon_ranges(
      three_beacons(), {{0.0, a, b, 1.75}, {1.0, a, b, 1.7501}, {2.0, a, b, 2.5}, {3.0, a, b, 2.5001}});
  EXPECT_NEAR(ranges.pairs[0].tof_s, 1.00005, 1e-9);
  EXPECT_EQ(ranges.pairs[0].left_out, 2U);
}

}  // namespace beacon_ranges_test
}  // namespace octant::test
