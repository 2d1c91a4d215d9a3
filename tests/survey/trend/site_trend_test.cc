// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/trend/site_trend.h"

#include <gtest/gtest.h>

#include "models/simulator/random.h"

namespace octant::survey {
namespace site_trend_test {

constexpr double kMonth = 30.0 * 86400.0;

std::vector<CalibrationRecord> years(Random& draws, int months) {
  std::vector<CalibrationRecord> records;
  for (int m = 0; m < months; ++m) {
    CalibrationRecord r;
    r.time_s = m * kMonth;
    r.speed_mps = 344.0;
    r.speed_sigma_mps = 0.03;
    r.speed_offset_mps = 0.5 + 0.03 * draws.normal();
    for (int b = 0; b < 8; ++b) {
      const bool held = b < 3;
      std::string name = "B";
      name += std::to_string(b);
      DeploymentBeacon beacon{.name = name,
                              .position_m = Eigen::Vector3d(3.0 * b, 5.0 * (b % 2), 2.5),
                              .delay_s = 1e-4 + 2e-6 * draws.normal(),
                              .delay_sigma_s = 2e-6};
      beacon.status = held ? BeaconStatus::kControlPoint : BeaconStatus::kCalibrated;
      if (!held) {
        beacon.covariance_m2 = 1e-6 * Eigen::Matrix3d::Identity();
        beacon.position_m += 1e-3 * draws.normal3();
      }
      r.beacons.push_back(beacon);
    }
    records.push_back(r);
  }
  return records;
}

std::size_t alarms(const SiteTrend& trend) {
  std::size_t count = 0;
  for (const QuantityTrend& q : trend.quantities) count += q.chart.shifts.size();
  return count;
}

// All charts together have the given rate of alarms: 150 sites of 20 visits have 30 alarms at most, at one in
// a hundred visits each.
TEST(SiteTrend, FalseAlarmsOfAllChartsTogetherAreAsRareAsStated) {
  Random draws(1);
  std::size_t count = 0;
  for (int site = 0; site < 150; ++site) count += alarms(site_trend(years(draws, 20)));
  EXPECT_LE(count, 30u + 22u);  // 4 sigmas of Poisson
  EXPECT_GE(count, 5u);
}

TEST(SiteTrend, HeldPlacesHaveNoChartAndLimitsFitTheirUnits) {
  Random draws(2);
  const SiteTrend trend = site_trend(years(draws, 6), {.limit_m = 0.03});
  // 3 control points with delays alone, 5 beacons with all four, the speed.
  ASSERT_EQ(trend.quantities.size(), 3u + 20u + 1u);
  EXPECT_EQ(trend.quantities[0].quantity, TrendQuantity::kDelay);
  EXPECT_NEAR(trend.quantities[0].limit, 0.03 / 344.0, 1e-12);
  const QuantityTrend& speed = trend.quantities.back();
  EXPECT_EQ(speed.subject, "medium");
  const double reach_m = 0.5 * std::hypot(21.0, 5.0);
  EXPECT_NEAR(speed.limit, 0.03 * 344.0 / reach_m, 0.01);
}

TEST(SiteTrend, UndeterminedBeaconsAreLeftOutAndNewOnesBeginLater) {
  Random draws(3);
  auto records = years(draws, 6);
  for (int m = 0; m < 3; ++m)
    records[static_cast<std::size_t>(m)].beacons.back().status = BeaconStatus::kUndetermined;
  const SiteTrend trend = site_trend(records);
  for (const QuantityTrend& q : trend.quantities)
    if (q.subject == "B7") {
      EXPECT_EQ(q.chart.points.size(), 3u);
    }
}

TEST(SiteTrend, TheDriftThatComesFirstSetsTheDate) {
  Random draws(4);
  auto records = years(draws, 12);
  for (CalibrationRecord& r : records) {
    r.beacons[5].position_m.y() += 2e-3 * r.time_s / kMonth;
    r.beacons[6].position_m.x() -= 1e-3 * r.time_s / kMonth;
  }
  const SiteTrend trend = site_trend(records, {.limit_m = 0.05});
  ASSERT_TRUE(trend.due);
  EXPECT_EQ(trend.quantities[*trend.due].subject, "B5");
  EXPECT_NEAR(*trend.quantities[*trend.due].forecast->due_s / kMonth, 11 + 25, 5);
  ASSERT_TRUE(trend.earliest);
  EXPECT_LE(trend.quantities[*trend.earliest].forecast->earliest_s,
            trend.quantities[*trend.due].forecast->earliest_s);
}

// Six millimetres with a sigma of one are no alarm, and once counted as a drift of that beacon.
TEST(SiteTrend, ABeaconThatMovedDriftsInNoCoordinate) {
  Random draws(6);
  auto records = years(draws, 1);
  records.push_back(records.front());
  records[1].time_s += kMonth;
  records[1].beacons[5].position_m += Eigen::Vector3d(0.0, 0.05, 0.006);
  records[1].beacons[6].position_m.z() += 0.006;
  const SiteTrend trend = site_trend(records, {.limit_m = 0.05});
  EXPECT_EQ(alarms(trend), 1u);
  for (const QuantityTrend& q : trend.quantities) {
    if (q.subject == "B5" && q.quantity != TrendQuantity::kDelay)
      EXPECT_FALSE(q.chart.drift || q.forecast) << to_string(q.quantity);
    if (q.subject == "B6") EXPECT_TRUE(q.forecast) << to_string(q.quantity);
  }
  ASSERT_TRUE(trend.due);
  EXPECT_EQ(trend.quantities[*trend.due].subject, "B6") << "which did not move in any other coordinate";
}

TEST(SiteTrend, NothingAndOneVisit) {
  EXPECT_TRUE(site_trend({}).quantities.empty());
  Random draws(5);
  const SiteTrend one = site_trend(years(draws, 1));
  EXPECT_FALSE(one.due || one.earliest);
  EXPECT_EQ(alarms(one), 0u);
}

}  // namespace site_trend_test
}  // namespace octant::survey
